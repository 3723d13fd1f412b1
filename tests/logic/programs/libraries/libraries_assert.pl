% library(assert): the program changes itself.
:- use_module(library(assert)).
:- assertz(fact(1)).
:- assertz((derived(X) :- fact(X))).
gone(1). gone(2).
:- retract(gone(1)).
note(X) :- assertz(kept(X)), kept(X).
query(fact(_)). query(derived(_)). query(gone(_)). query(note(a)).
% expect: fact(1) = 1
% expect: derived(1) = 1
% expect: gone(2) = 1
% expect: note(a) = 1
