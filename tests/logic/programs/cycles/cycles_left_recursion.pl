% Left recursion.
0.5::e(a, b). 0.5::e(b, c). 0.5::e(c, a).
reach(X, Y) :- reach(X, Z), e(Z, Y).
reach(X, Y) :- e(X, Y).
query(reach(a, _)).
% expect: reach(a,b) = 0.5
% expect: reach(a,c) = 0.25
% expect: reach(a,a) = 0.125
