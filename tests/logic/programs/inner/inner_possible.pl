% possible/1: whether a goal has any way to hold.
0.4::a(1). a(2) :- fail. 0.1::a(3).
b(X) :- possible(a(X)).
query(b(_)).
% expect: b(1) = 1
% expect: b(3) = 1
