% subquery/2: the probability of a goal as a value.
0.4::a. 0.3::b :- a.
p(P) :- subquery(b, P).
likely(X) :- subquery(c(X), P), P > 0.4.
0.5::c(1). 0.2::c(2). 0.6::c(3).
query(p(_)). query(likely(_)).
% expect: p(0.12) = 1
% expect: likely(1) = 1
% expect: likely(3) = 1
