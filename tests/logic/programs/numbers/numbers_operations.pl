% Arithmetic.
a(X) :- X is 7 // 2. b(X) :- X is 7 mod 2. c(X) :- X is 7 / 2. d(X) :- X is 2 ** 3. e(X) :- X is max(2, 3) - min(2, 3).
f(X) :- X is abs(-4) + sign(-2). g(X) :- X is round(2.6) + floor(2.6) + ceiling(2.2) + truncate(2.9). h(X) :- X is sqrt(16) + exp(0) + log(1).
i(X) :- X is integer(2.7) + float(2). j :- 1 + 1 =:= 2, 3 =\= 4, 1 =< 1, 2 >= 1. k(X) :- X is 5 - 8. l(X) :- X is 1 << 3. m(X) :- X is 6 /\ 3.
query(a(_)). query(b(_)). query(c(_)). query(d(_)). query(e(_)). query(f(_)). query(g(_)). query(h(_)). query(i(_)). query(j). query(k(_)). query(l(_)). query(m(_)).
% expect: a(3) = 1
% expect: b(1) = 1
% expect: c(3.5) = 1
% expect: d(8) = 1
% expect: e(1) = 1
% expect: f(3) = 1
% expect: g(10) = 1
% expect: h(5.0) = 1
% expect: i(4.0) = 1
% expect: j = 1
% expect: k(-3) = 1
% expect: l(8) = 1
% expect: m(2) = 1
