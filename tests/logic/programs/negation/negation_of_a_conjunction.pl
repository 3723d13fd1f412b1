% Negation of conjunctions and disjunctions.
0.3::a. 0.5::b.
neither :- \+(a; b).
notboth :- \+(a, b).
query(neither). query(notboth).
% expect: neither = 0.35
% expect: notboth = 0.85
