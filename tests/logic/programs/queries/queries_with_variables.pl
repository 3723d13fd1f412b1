% A query with variables has an answer a binding.
0.4::in(cat, box). 0.7::in(dog, yard). in(bird, cage).
query(in(_, _)).
query(in(cat, X)).
% expect: in(cat,box) = 0.4
% expect: in(dog,yard) = 0.7
% expect: in(bird,cage) = 1
