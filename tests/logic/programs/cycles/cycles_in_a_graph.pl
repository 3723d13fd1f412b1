% Paths in a graph with cycles.
0.6::edge(1, 2). 0.1::edge(2, 1). 0.4::edge(2, 3). 0.3::edge(1, 3). 0.8::edge(3, 1).
path(X, Y) :- edge(X, Y).
path(X, Y) :- edge(X, Z), path(Z, Y).
query(path(1, _)).
% expect: path(1,2) = 0.6
% expect: path(1,3) = 0.468
% expect: path(1,1) = 0.40656
