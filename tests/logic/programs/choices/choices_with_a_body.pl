% Choices that are made only where a body holds.
0.5::cloudy.
0.6::rain; 0.1::snow :- cloudy.
0.05::rain :- \+cloudy.
query(rain). query(snow).
% expect: rain = 0.325
% expect: snow = 0.05
