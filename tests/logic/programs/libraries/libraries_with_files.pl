% library(db) reads files: refused.
:- use_module(library(db)).
:- csv_load('people.csv', person).
0.3::a.
query(a).
% expect refused: 2:4
