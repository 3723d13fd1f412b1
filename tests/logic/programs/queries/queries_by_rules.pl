% Queries that a body finds.
0.4::p(1). 0.3::p(2). 0.2::p(3).
wanted(2). wanted(3).
query(p(X)) :- wanted(X).
query(X) :- X = p(1).
% expect: p(2) = 0.3
% expect: p(3) = 0.2
% expect: p(1) = 0.4
