% Negated evidence, and evidence about a rule.
0.4::a. 0.5::b.
c :- a, b.
evidence(\+c).
query(a). query(b).
% expect: a = 0.25
% expect: b = 0.375
