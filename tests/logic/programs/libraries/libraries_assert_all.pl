% library(assert): retractall/1.
:- use_module(library(assert)).
state(1). state(2). other(3).
:- retractall(state(_)).
query(state(_)). query(other(_)).
% expect: state(X2) = 0
% expect: other(3) = 1
