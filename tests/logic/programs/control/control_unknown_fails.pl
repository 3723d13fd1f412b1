% Unknown predicates may be made to fail.
:- unknown(fail).
0.3::a.
b :- undefined(1). b :- a, \+undefined(2).
query(b).
% expect: b = 0.3
