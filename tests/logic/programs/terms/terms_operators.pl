% Terms written with operators.
a(1 + 2 * 3). a(x - (y - z)). a(-1). a(-(x)). a(2 ** 3). a(a / b). a(x = y). a((k, l)). a([h | t]). a(1.5e-3).
query(a(_)).
% expect: a(1+2*3) = 1
% expect: a(x-(y-z)) = 1
% expect: a(-1) = 1
% expect: a(-(x)) = 1
% expect: a(2**3) = 1
% expect: a(a/b) = 1
% expect: a(x=y) = 1
% expect: a((k, l)) = 1
% expect: a([h | t]) = 1
% expect: a(0.0015) = 1
