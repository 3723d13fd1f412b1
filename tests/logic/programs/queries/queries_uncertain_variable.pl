% A probable answer with an unbound variable has no meaning.
0.3::a.
any(X) :- a.
query(any(_)).
% expect error: NonGroundError
