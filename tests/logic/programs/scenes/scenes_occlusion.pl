% What is behind what: explaining away a hidden object.
0.5::there(cup). 0.4::there(box). 
in_front(box, cup).
hidden(X) :- in_front(Y, X), there(Y).
0.9::seen(X) :- there(X), \+hidden(X).
evidence(\+seen(cup)). evidence(seen(box)).
query(there(cup)).
% expect: there(cup) = 0.5
