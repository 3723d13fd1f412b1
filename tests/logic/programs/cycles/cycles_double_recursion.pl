% A predicate that calls itself twice.
0.5::link(a, b). 0.5::link(b, c). 0.5::link(c, d).
way(X, Y) :- link(X, Y).
way(X, Y) :- way(X, Z), way(Z, Y).
query(way(a, d)). query(way(a, c)).
% expect: way(a,d) = 0.125
% expect: way(a,c) = 0.25
