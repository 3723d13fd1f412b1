% findall/3 keeps the order of the program, sort/2 does not.
p(c). p(a). p(b). p(a).
a(L) :- findall(X, p(X), L).
b(S) :- findall(X, p(X), L), sort(L, S).
query(a(_)). query(b(_)).
% expect: a([c, a, b, a]) = 1
% expect: b([a, b, c]) = 1
