% Arithmetic on what is not bound.
a(X) :- X > 1.
query(a(_)).
% expect error: ProgramError
