% subquery/3 with evidence, subquery/5 by another compiler.
0.4::a. 0.3::b :- a. 0.1::b :- \+a.
p(P) :- subquery(a, P, [b]).
q(P) :- subquery(a, P, [\+b]).
r(P) :- subquery(a, P, [b], "prob", "sdd").
query(p(_)). query(q(_)). query(r(_)).
% expect: p(0.666666666666667) = 1
% expect: q(0.341463414634146) = 1
% expect: r(0.666666666666667) = 1
