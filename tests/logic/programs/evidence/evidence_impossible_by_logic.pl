% Evidence for what cannot be.
0.3::a. b :- a, \+a.
evidence(b).
query(a).
% expect error: InconsistentError
