% Recursion over numbers with an uncertain step.
0.9::step(N) :- between(1, 5, N).
climbs(0).
climbs(N) :- N > 0, step(N), M is N - 1, climbs(M).
factorial(0, 1).
factorial(N, F) :- N > 0, M is N - 1, factorial(M, G), F is N * G.
query(climbs(3)). query(factorial(5, _)).
% expect: climbs(3) = 0.729
% expect: factorial(5,120) = 1
