% Directives that ProbLog does not know.
:- dynamic(p/1).
0.3::a.
query(a).
% expect error: UnknownPredicateError
