% A label that the body binds.
strength(weak, 0.2). strength(strong, 0.9).
P::holds(R) :- strength(R, P).
query(holds(_)).
% expect: holds(weak) = 0.2
% expect: holds(strong) = 0.9
