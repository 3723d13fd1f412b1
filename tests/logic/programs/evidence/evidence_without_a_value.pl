% evidence/2 with neither true nor false is only named.
0.3::a.
evidence(a, maybe).
query(a).
% expect: a = 0.3
