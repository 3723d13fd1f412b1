% library(control): a goal to fall back on.
:- use_module(library(control)).
0.3::main. 0.5::spare.
works :- on_fail(main, spare).
query(works).
% expect: works = 0.65
