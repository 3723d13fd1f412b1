% A variable as a goal, positive and negated.
0.3::p(1). 0.6::p(2).
holds(G) :- G.
fails(G) :- \+G.
query(holds(p(1))). query(fails(p(2))). query(holds((p(1), p(2)))) :- fail.
% expect: holds(p(1)) = 0.3
% expect: fails(p(2)) = 0.4
