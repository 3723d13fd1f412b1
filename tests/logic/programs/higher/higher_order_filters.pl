% include, exclude and partition on uncertain tests.
:- use_module(library(apply)).
0.5::good(1). good(2). 0.2::good(3).
a(L) :- include(good, [1, 2, 3], L).
b(L) :- exclude(good, [1, 2, 3], L).
c(I, O) :- partition(good, [1, 2], I, O).
query(a(_)). query(b(_)). query(c(_, _)).
% expect: a([1, 2, 3]) = 0.1
% expect: a([1, 2]) = 0.4
% expect: a([2, 3]) = 0.1
% expect: a([2]) = 0.4
% expect: b([1, 3]) = 0.4
% expect: b([1]) = 0.1
% expect: b([3]) = 0.4
% expect: b([]) = 0.1
% expect: c([1, 2],[]) = 0.5
% expect: c([2],[1]) = 0.5
