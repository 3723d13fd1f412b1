% library(record): values by key.
:- use_module(library(record)).
:- recordz(box, first). 
:- recordz(box, second).
:- recorda(box, zeroth).
a(X) :- recorded(box, X).
query(a(_)).
% expect: a(zeroth) = 1
% expect: a(first) = 1
% expect: a(second) = 1
