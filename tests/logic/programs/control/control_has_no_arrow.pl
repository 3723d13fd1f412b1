% ProbLog has no if-then-else.
0.3::a.
b :- (a -> true ; fail).
query(b).
% expect error: UnknownPredicateError
