% member/2, memberchk/2 and select/3.
:- use_module(library(lists)).
0.5::fruit(X) :- member(X, [apple, pear]).
in(X) :- memberchk(X, [apple, fig]), fruit(X).
left(R) :- select(b, [a, b, c], R).
query(fruit(_)). query(in(apple)). query(left(_)).
% expect: fruit(apple) = 0.5
% expect: fruit(pear) = 0.5
% expect: in(apple) = 0.5
% expect: left([a, c]) = 1
