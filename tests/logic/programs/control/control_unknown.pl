% A call of what has no clauses.
0.3::a.
b :- a, undefined(X).
query(b).
% expect error: UnknownPredicateError
