% What ProbLog defines cannot be defined again.
length(a, b).
0.3::a.
query(a).
% expect error: ProgramError
