% A hidden Markov chain, seen three times.
time(0). time(1). time(2).
0.6::state(0, good); 0.4::state(0, bad).
0.9::state(T, good); 0.1::state(T, bad) :- T > 0, U is T - 1, state(U, good).
0.2::state(T, good); 0.8::state(T, bad) :- T > 0, U is T - 1, state(U, bad).
0.05::noise(T) :- state(T, good).
0.5::noise(T) :- state(T, bad).
evidence(noise(0), false). evidence(noise(1), true). evidence(noise(2), true).
query(state(2, bad)).
% expect: state(2,bad) = 0.9505590431
