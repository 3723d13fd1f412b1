% A query that fails, ground and with a variable.
p(1).
q(X) :- p(X), X > 5.
query(q(1)). query(q(_)). query(p(2)).
% expect: q(1) = 0
% expect: q(X2) = 0
% expect: p(2) = 0
