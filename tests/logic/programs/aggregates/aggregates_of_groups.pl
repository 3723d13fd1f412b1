% Aggregates in heads, by group.
:- use_module(library(aggregate)).
paid(ann, 10). paid(ann, 20). paid(bob, 5).
total(P, sum<X>) :- paid(P, X).
most(max<X>) :- paid(_, X).
least(min<X>) :- paid(_, X).
mean(P, avg<X>) :- paid(P, X).
query(total(_, _)). query(most(_)). query(least(_)). query(mean(_, _)).
% expect: total(ann,30) = 1
% expect: total(bob,5) = 1
% expect: most(20) = 1
% expect: least(5) = 1
% expect: mean(ann,15.0) = 1
% expect: mean(bob,5.0) = 1
