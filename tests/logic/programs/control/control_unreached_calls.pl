% What is never called may be unknown.
0.3::a.
b :- fail, undefined(1).
c :- undefined(2).
query(a). query(b).
% expect: a = 0.3
% expect: b = 0
