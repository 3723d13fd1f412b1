% An aggregate over uncertain facts has an answer a world.
:- use_module(library(aggregate)).
0.5::won(ann, 10). 0.4::won(ann, 20). won(bob, 1).
total(P, sum<X>) :- won(P, X).
query(total(_, _)).
% expect: total(ann,30) = 0.2
% expect: total(bob,1) = 1
% expect: total(ann,20) = 0.2
% expect: total(ann,10) = 0.3
