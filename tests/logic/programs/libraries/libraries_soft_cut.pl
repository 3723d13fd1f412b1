% library(cut): the first clause that applies.
:- use_module(library(cut)).
rule(1, ann, tea). 0.5::rule(2, bob, milk). rule(3, bob, water). rule(4, cid, none).
drink(X, Y) :- cut(rule(X, Y)).
which(I) :- cut(rule(bob, _), I).
query(drink(ann, _)). query(drink(bob, _)). query(which(_)).
% expect: drink(ann,tea) = 1
% expect: drink(bob,milk) = 0.5
% expect: drink(bob,water) = 0.5
% expect: which(2) = 0.5
% expect: which(3) = 0.5
