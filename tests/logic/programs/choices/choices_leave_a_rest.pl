% An annotated disjunction whose rest is: none of them.
0.2::red; 0.3::green.
none :- \+red, \+green.
query(red). query(green). query(none).
% expect: red = 0.2
% expect: green = 0.3
% expect: none = 0.5
