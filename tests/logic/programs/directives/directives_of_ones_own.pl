% Directives call goals; what they call is forgotten.
p(1). 0.5::q(X) :- p(X).
:- p(X), X > 0.
:- q(_).
query(q(_)).
% expect: q(1) = 0.5
