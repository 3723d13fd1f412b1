% Predicates passed through predicates.
:- use_module(library(apply)).
twice(P, X, Z) :- call(P, X, Y), call(P, Y, Z).
0.9::next(X, Y) :- Y is X + 1.
a(X) :- twice(next, 1, X).
b(L) :- maplist(twice(next), [1, 2], L).
query(a(_)). query(b(_)).
% expect: a(3) = 0.81
% expect: b([3, 4]) = 0.729
