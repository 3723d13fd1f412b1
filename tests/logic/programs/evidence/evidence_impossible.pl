% Evidence that no world satisfies.
0.3::a. b :- a.
evidence(b). evidence(\+a).
query(a).
% expect error: InconsistentError
