% Other files are refused.
:- consult('more.pl').
0.3::a.
query(a).
% expect refused: 2:4
