% Layers of negation.
0.5::a. 0.5::b.
c :- \+a. d :- \+c, b. e :- \+d.
query(c). query(d). query(e).
% expect: c = 0.5
% expect: d = 0.25
% expect: e = 0.75
