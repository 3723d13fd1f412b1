% A program may stop with an error of its own.
0.3::a.
b :- a, error('no such ', thing).
query(b).
% expect error: ProgramError
