% Negation as failure of a choice.
0.3::rain.
dry :- \+rain.
query(dry).
% expect: dry = 0.7
