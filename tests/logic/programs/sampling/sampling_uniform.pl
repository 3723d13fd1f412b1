% sample_uniform1/3: one of a list.
a(X) :- sample_uniform1(key, [x, y, z], X).
query(a(_)).
% expect: a(x) = 0.3333333333
% expect: a(y) = 0.3333333333
% expect: a(z) = 0.3333333333
