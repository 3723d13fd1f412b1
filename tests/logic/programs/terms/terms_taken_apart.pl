% arg/3, functor/3 and =../2.
a(X) :- arg(2, point(3, 4), X).
b(F, N) :- functor(point(3, 4), F, N).
c(L) :- point(3, 4) =.. L.
d(T) :- T =.. [point, 5, 6].
e(X) :- functor(X, leaf, 0).
query(a(_)). query(b(_, _)). query(c(_)). query(d(_)). query(e(_)).
% expect: a(4) = 1
% expect: b(point,2) = 1
% expect: c([point, 3, 4]) = 1
% expect: d(point(5,6)) = 1
% expect: e(leaf) = 1
