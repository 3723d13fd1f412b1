% Probabilistic facts and a rule with two ways.
0.3::rain.
0.5::sprinkler.
wet :- rain.
wet :- sprinkler.
query(rain).
query(wet).
% expect: rain = 0.3
% expect: wet = 0.65
