% Disjunctions in bodies, with precedence.
0.3::a. 0.4::b. 0.5::c.
d :- a, b ; c.
e :- a, (b ; c).
f :- (a ; b), \+c.
query(d). query(e). query(f).
% expect: d = 0.56
% expect: e = 0.21
% expect: f = 0.29
