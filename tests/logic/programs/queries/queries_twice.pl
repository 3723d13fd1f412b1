% The same query twice is one answer.
0.3::a.
query(a). query(a).
% expect: a = 0.3
