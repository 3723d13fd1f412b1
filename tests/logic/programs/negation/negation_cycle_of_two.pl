% A negative cycle through two predicates.
0.5::t.
win :- t, \+lose.
lose :- t, \+win.
query(win).
% expect error: NegativeCycleError
