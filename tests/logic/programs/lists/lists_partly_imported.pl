% Named imports, renamed imports, exceptions.
:- use_module(library(lists), [member/2, reverse/2 as backwards]).
:- use_module(library(apply), except([maplist/2])).
maplist(own, _).
a(X) :- member(X, [1, 2]). b(L) :- backwards([1, 2], L). c(X) :- maplist(X, [1]).
query(a(_)). query(b(_)). query(c(_)).
% expect: a(1) = 1
% expect: a(2) = 1
% expect: b([2, 1]) = 1
% expect: c(own) = 1
