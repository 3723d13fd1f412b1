% call/N adds arguments.
0.3::edge(a, b). 0.6::edge(a, c).
next(P, X, Y) :- call(P, X, Y).
from_a(Y) :- call(edge(a), Y).
query(next(edge, a, _)). query(from_a(_)).
% expect: next(edge,a,b) = 0.3
% expect: next(edge,a,c) = 0.6
% expect: from_a(b) = 0.3
% expect: from_a(c) = 0.6
