% not, \+ and nested negation.
0.3::a.
b :- not a.
c :- \+ \+a.
d :- \+(\+(\+a)).
query(b). query(c). query(d).
% expect: b = 0.7
% expect: c = 0.3
% expect: d = 0.7
