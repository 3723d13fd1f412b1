% An annotated disjunction that sums to 1.
1/6::die(1); 1/6::die(2); 1/6::die(3); 1/6::die(4); 1/6::die(5); 1/6::die(6).
even :- die(X), 0 =:= X mod 2.
high :- die(X), X >= 5.
query(even). query(high). query(die(6)).
% expect: even = 0.5
% expect: high = 0.3333333333
% expect: die(6) = 0.1666666667
