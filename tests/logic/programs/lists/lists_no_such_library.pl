% A library that does not exist.
:- use_module(library(no_such_library)).
0.3::a.
query(a).
% expect refused: 2:4
