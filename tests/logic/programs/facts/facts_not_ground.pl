% A fact with a variable holds of everything that is asked.
likes(X, X).
likes(ann, _).
query(likes(bob, bob)). query(likes(ann, tea)). query(likes(bob, tea)).
% expect: likes(bob,bob) = 1
% expect: likes(ann,tea) = 1
% expect: likes(bob,tea) = 0
