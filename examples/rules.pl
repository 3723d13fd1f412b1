% Rules of one's own (docs/knowledge-bases.md): what a knowledge base's rules.pl, or a file for --rules, may hold.

% A choice, a rule, and what was observed: nothing slipped.
0.1::wet.
0.5::slips(X) :- object(X, t1), wet.
slipped :- slips(_).
evidence(\+ slipped).

% Constraints: no world has two objects of one type; two within 1.5 m of each other are improbable.
constraint(one_of_a_kind(T)) :- object(X, T), object(Y, T), X \= Y.
constraint(crowded(X, Y)) :- near(X, Y, 1.5), X @< Y.
0.25::constraint_may_fail(crowded(_, _)).
