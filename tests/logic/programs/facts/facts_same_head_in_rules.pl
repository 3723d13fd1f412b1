% Facts and rules of one predicate side by side.
0.2::lit(hall).
lit(R) :- 0.5 > 0.4, switch(R).
0.7::switch(hall). 0.1::switch(attic).
query(lit(_)).
% expect: lit(hall) = 0.76
% expect: lit(attic) = 0.1
