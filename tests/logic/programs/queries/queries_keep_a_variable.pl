% A query that keeps a variable, and is certain.
same(X, X).
query(same(_, _)).
query(same(f(A), B)).
% expect: same(X2,X2) = 1
% expect: same(f(X2),f(X2)) = 1
