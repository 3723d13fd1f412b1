% A query about a predicate that nothing defines.
0.3::a.
query(b).
% expect error: UnknownPredicateError
