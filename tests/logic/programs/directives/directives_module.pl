% A module keeps its predicates to itself, queries too.
:- module(private, [a/0]).
0.3::a.
query(a).
% expect nothing
