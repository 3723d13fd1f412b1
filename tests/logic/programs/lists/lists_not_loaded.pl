% Libraries are not there unless they are loaded.
a(X) :- member(X, [1, 2]).
query(a(_)).
% expect error: UnknownPredicateError
