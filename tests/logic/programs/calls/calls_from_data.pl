% Rules as data, interpreted.
rule(wet, [rain]). rule(wet, [hose]). rule(slippery, [wet, cold]).
0.3::base(rain). 0.2::base(hose). 0.5::base(cold).
prove(G) :- base(G).
prove(G) :- rule(G, B), every(B).
every([]).
every([G|R]) :- prove(G), every(R).
query(prove(wet)). query(prove(slippery)).
% expect: prove(wet) = 0.44
% expect: prove(slippery) = 0.22
