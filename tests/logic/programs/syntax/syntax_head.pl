% A number is no head.
1 :- a.
0.3::a.
query(a).
% expect error: ProgramError
