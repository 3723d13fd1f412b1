% A label that the body computes.
distance(ann, 2). distance(bob, 4).
P::hears(X) :- distance(X, D), P is 1 / D.
query(hears(_)).
% expect: hears(ann) = 0.5
% expect: hears(bob) = 0.25
