% A uniform and a weighted draw, twice from the same urn.
:- use_module(library(lists)).
first(X, R) :- select_uniform(one, [a, b, c], X, R).
second(Y) :- first(X, R), select_uniform(two(X), R, Y, _).
biased(X) :- select_weighted(three, [0.2, 0.3, 0.5], [x, y, z], X, _).
query(second(_)). query(biased(_)).
% expect: second(b) = 0.3333333333
% expect: second(c) = 0.3333333333
% expect: second(a) = 0.3333333333
% expect: biased(x) = 0.2
% expect: biased(y) = 0.3
% expect: biased(z) = 0.5
