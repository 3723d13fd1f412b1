% An aggregate function of the program's own.
:- use_module(library(aggregate)).
score(5). score(7). score(6).
range([H|T], R) :- max([H|T], A), min([H|T], B), R is A - B.
spread(range<X>) :- score(X).
query(spread(_)).
% expect: spread(2) = 1
