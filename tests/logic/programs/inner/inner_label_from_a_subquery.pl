% A probability of the program as a label of the program.
0.4::a. 0.5::b.
both :- a, b.
P::copy :- subquery(both, P).
query(copy). query(both).
% expect: copy = 0.2
% expect: both = 0.2
