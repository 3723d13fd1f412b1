% Unification, identity, order.
a :- f(X, b) = f(a, Y), X == a, Y == b.
b :- f(a) \= g(a), f(a) \== f(b).
c(O) :- compare(O, 1, 2). d(O) :- compare(O, f(b), f(a)).
e :- a @< b, f(a) @> b, "s" @< a, 1 @< a, 2 @=< 2, 3 @>= 2.
query(a). query(b). query(c(_)). query(d(_)). query(e).
% expect: a = 1
% expect: b = 1
% expect: c('<') = 1
% expect: d('>') = 1
% expect: e = 1
