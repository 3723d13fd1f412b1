% findall/3 of a goal that is passed in.
0.4::p(1). p(2). q(5).
gather(G, X, L) :- findall(X, G, L).
a(L) :- gather(p(X), X, L).
b(L) :- gather((p(X), q(Y)), X-Y, L).
query(a(_)). query(b(_)).
% expect: a([1, 2]) = 0.4
% expect: a([2]) = 0.6
% expect: b([1-5, 2-5]) = 0.4
% expect: b([2-5]) = 0.6
