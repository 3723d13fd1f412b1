% Every head of a disjunction needs a probability.
0.4::a; b.
query(a).
% expect error: ProgramError
