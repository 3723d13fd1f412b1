% clause/2 and clause/3 look at the program.
p(1). p(X) :- q(X), r(X). q(2). 0.5::r(2).
bodies(B) :- clause(p(2), B).
heads(P) :- clause(r(X), true, P).
query(bodies(_)). query(heads(_)).
% expect: bodies((q(X2), r(X2))) = 1
% expect: heads(0.5) = 1
