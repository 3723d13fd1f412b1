% between/3, succ/2, plus/3, length/2.
0.5::coin(X) :- between(1, 3, X).
a(X) :- succ(X, 4). b(X) :- succ(4, X). c(X) :- plus(1, X, 5). d(N) :- length([a, b], N). e(N) :- findall(X, coin(X), L), length(L, N).
query(a(_)). query(b(_)). query(c(_)). query(d(_)). query(e(_)).
% expect: a(3) = 1
% expect: b(5) = 1
% expect: c(4) = 1
% expect: d(2) = 1
% expect: e(3) = 0.125
% expect: e(2) = 0.375
% expect: e(1) = 0.375
% expect: e(0) = 0.125
