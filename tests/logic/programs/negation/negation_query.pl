% A query may be a negation.
0.3::a. 0.2::b(1). 0.4::b(2).
query(\+a).
query(\+b(1)).
% expect: \+a = 0.7
% expect: \+b(1) = 0.8
