% A collection that depends on itself.
p(1).
q(X) :- findall(Y, q(Y), L), p(X).
query(q(1)).
% expect error: ProgramError
