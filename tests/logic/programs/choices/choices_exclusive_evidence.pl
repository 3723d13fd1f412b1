% Evidence against one choice of a disjunction raises the others.
0.5::a; 0.3::b; 0.2::c.
evidence(\+a).
query(a). query(b). query(c).
% expect: a = 0
% expect: b = 0.6
% expect: c = 0.4
