% library(scope): facts of several theories.
:- use_module(library(scope)).
0.3::base:rain. 0.5::garden:hose.
garden:wet :- base:rain.
garden:wet :- garden:hose.
both :- [base, garden]:(rain, hose).
query(garden:wet). query(both).
% expect: garden:wet = 0.65
% expect: both = 0.15
