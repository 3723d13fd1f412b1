% A program without queries has no answers.
0.3::a. b :- a.
% expect nothing
