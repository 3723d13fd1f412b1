% Division by zero.
a(X) :- X is 1 / 0.
query(a(_)).
% expect error: ProgramError
