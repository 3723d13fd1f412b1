% Negative heads: causes that inhibit.
0.8::flies :- bird.
0.9:: \+flies :- penguin.
bird. 0.3::penguin.
query(flies).
% expect: flies = 0.584
