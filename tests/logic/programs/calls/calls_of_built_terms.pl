% Goals put together at run time.
0.3::p(1, x). 0.6::q(2).
b :- G =.. [p, 1, x], call(G).
c :- functor(G, q, 1), G = q(2), G.
d :- call((p(1, x), q(2))) .
query(b). query(c).
% expect: b = 0.3
% expect: c = 0.6
