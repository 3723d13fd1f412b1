% append, reverse, nth, last, flatten, permutation.
:- use_module(library(lists)).
a(X, Y) :- append(X, Y, [1, 2]).
b(L) :- reverse([1, 2, 3], L).
c(X) :- nth0(1, [a, b, c], X).
d(X) :- nth1(1, [a, b, c], X).
e(X) :- last([1, 2, 3], X).
f(L) :- flatten([1, [2, [3]], 4], L).
g(L) :- permutation([1, 2, 3], L).
query(a(_, _)). query(b(_)). query(c(_)). query(d(_)). query(e(_)). query(f(_)). query(g(_)).
% expect: a([],[1, 2]) = 1
% expect: a([1],[2]) = 1
% expect: a([1, 2],[]) = 1
% expect: b([3, 2, 1]) = 1
% expect: c(b) = 1
% expect: d(a) = 1
% expect: e(3) = 1
% expect: f([1, 2, 3, 4]) = 1
% expect: g([1, 2, 3]) = 1
% expect: g([1, 3, 2]) = 1
% expect: g([2, 1, 3]) = 1
% expect: g([2, 3, 1]) = 1
% expect: g([3, 1, 2]) = 1
% expect: g([3, 2, 1]) = 1
