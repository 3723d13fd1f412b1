% A parenthesis that is not closed.
0.3::a.
b :- (a, c.
query(a).
% expect error: ProgramError
