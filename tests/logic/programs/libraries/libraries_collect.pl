% library(collect): collecting by group.
:- use_module(library(collect)).
0.5::eats(ann, fish). eats(ann, rice). eats(bob, soup).
menu(P, L) :- eats(P, X) => P / list(X, L).
query(menu(_, _)).
% expect: menu(ann,[fish, rice]) = 0.5
% expect: menu(bob,[soup]) = 1
% expect: menu(ann,[rice]) = 0.5
