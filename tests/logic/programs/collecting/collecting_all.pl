% all/3 fails where nothing is found; all_or_none/3 does not.
0.4::p(1). 0.5::p(2).
a(L) :- all(X, p(X), L).
b(L) :- all_or_none(X, p(X), L).
query(a(_)). query(b(_)).
% expect: a([1, 2]) = 0.2
% expect: a([2]) = 0.3
% expect: a([1]) = 0.2
% expect: b([1, 2]) = 0.2
% expect: b([2]) = 0.3
% expect: b([1]) = 0.2
% expect: b([]) = 0.3
