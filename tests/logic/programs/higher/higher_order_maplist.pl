% maplist with names and partial terms.
:- use_module(library(apply)).
0.5::double(1, 2). double(2, 4). double(1, 3).
a(L) :- maplist(double, [1, 2], L).
b(L) :- maplist(plus(10), [1, 2, 3], L).
small(X) :- X < 3.
c :- maplist(small, [1, 2]). d :- maplist(small, [1, 5]).
query(a(_)). query(b(_)). query(c). query(d).
% expect: a([2, 4]) = 0.5
% expect: a([3, 4]) = 1
% expect: b([11, 12, 13]) = 1
% expect: c = 1
% expect: d = 0
