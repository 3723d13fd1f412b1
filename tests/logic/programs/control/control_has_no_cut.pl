% ProbLog has no cut.
0.3::a.
b :- a, !.
query(b).
% expect error: UnknownPredicateError
