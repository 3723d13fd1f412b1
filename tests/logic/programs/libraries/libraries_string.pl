% library(string): joining and taking apart.
:- use_module(library(string)).
a(X) :- concat([ab, cd], X). b(X) :- join('-', [x, y, z], X). c(L) :- str2lst(cat, L). d(X) :- lst2str([c, a, t], X).
query(a(_)). query(b(_)). query(c(_)). query(d(_)).
% expect: a(abcd) = 1
% expect: b('x-y-z') = 1
% expect: c([c, a, t]) = 1
% expect: d(cat) = 1
