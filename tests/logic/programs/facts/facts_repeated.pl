% A fact written twice is two choices.
0.4::knock.
0.4::knock.
query(knock).
% expect: knock = 0.64
