% Inheritance: parents' genes given a child's type.
0.3::gene(P, S, a); 0.1::gene(P, S, b); 0.6::gene(P, S, o) :- founder(P), side(S).
founder(mum). founder(dad).
side(left). side(right).
0.5::passes(P, left); 0.5::passes(P, right) :- founder(P).
child(G) :- gene(mum, S, G), passes(mum, S).
child(G) :- gene(dad, S, G), passes(dad, S).
type(ab) :- child(a), child(b).
type(a) :- child(a), \+child(b).
type(b) :- child(b), \+child(a).
type(o) :- \+child(a), \+child(b).
evidence(type(o)).
query(gene(mum, left, o)). query(gene(dad, right, a)).
% expect: gene(mum,left,o) = 0.8
% expect: gene(dad,right,a) = 0.15
