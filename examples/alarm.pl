% Pearl's alarm. Who called, and why?
0.1::burglary.
0.2::earthquake(small); 0.05::earthquake(strong).
0.9::wakes(john). 0.6::wakes(mary).

alarm :- burglary, \+ jammed.
0.3::alarm :- earthquake(small).
alarm :- earthquake(strong).
0.1::jammed.

calls(X) :- alarm, wakes(X).

evidence(calls(john)).
query(burglary).
query(earthquake(_)).
query(calls(mary)).
