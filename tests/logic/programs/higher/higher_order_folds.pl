% foldl and scanl.
:- use_module(library(apply)).
add(X, Y, Z) :- Z is X + Y.
0.5::step(X, Y, Z) :- Z is X * Y.
a(S) :- foldl(add, [1, 2, 3], 0, S).
b(S) :- foldl(step, [2, 3], 1, S).
c(L) :- scanl(add, [1, 2, 3], 0, L).
query(a(_)). query(b(_)). query(c(_)).
% expect: a(6) = 1
% expect: b(6) = 0.25
% expect: c([1, 3, 6]) = 1
