% numbervars/3, subsumes_term/2, atom_number/2.
a(N) :- T = f(X, Y, X), numbervars(T, 0, N).
b :- subsumes_term(f(_), f(a)). c :- subsumes_term(f(a), f(_)).
d(A) :- atom_number(A, 12).
query(a(_)). query(b). query(c). query(d(_)).
% expect: a(f($Var(0),$Var(1),$Var(0))) = 1
% expect: b = 1
% expect: c = 0
% expect: d(12) = 1
