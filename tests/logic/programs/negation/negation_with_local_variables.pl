% Variables that occur in a negation only.
0.3::child(ann, tim). 0.5::child(ann, eve). 0.2::child(bob, kim).
person(ann). person(bob). person(cid).
childless(P) :- person(P), \+child(P, _).
query(childless(_)).
% expect: childless(ann) = 0.35
% expect: childless(bob) = 0.8
% expect: childless(cid) = 1
