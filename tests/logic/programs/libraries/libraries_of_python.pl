% Python is refused.
:- use_module('helper.py').
0.3::a.
query(a).
% expect refused: 2:4
