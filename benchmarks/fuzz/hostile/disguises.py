"""Programs that hide what they do, or try the terminal, the environment, Python, and what other Prologs have."""

from __future__ import annotations

from benchmarks.fuzz.hostile.program import Hostile, programs

DISGUISED = {
    "behind a comment that ends early": "/* % */ :- consult('{pl}'). /* */ a. query(a).",
    "behind a comment in a comment": "/* /* */ :- use_module('{py}'). a. query(a).",
    "behind a quote that a backslash ends": "b('\\\\'). :- consult('{pl}'). c('\\\\'). a. query(a).",
    "behind a doubled quote": "b(''''). :- consult('{pl}'). c(''''). a. query(a).",
    "behind a carriage return": "% nothing to see here\r:- consult('{pl}').\na. query(a).",
    "behind a line separator": "% nothing to see here\u2028:- consult('{pl}').\na. query(a).",
    "behind letters that turn the line round": "a. % \u202e '\u2066\n:- consult('{pl}'). % \u2069\nquery(a).",
    "in letters that look alike": "\u0441onsult(F) :- call(use_module, F). a :- \u0441onsult('{py}'). query(a).",
    "with a space of no width": "a :- use\u200b_module('{py}'). query(a).",
    "in letters of full width": "a :- \uff43\uff4f\uff4e\uff53\uff55\uff4c\uff54('{pl}'). query(a).",
    "in codes of letters": "a :- X = '\\x63\\onsult', G =.. [X, '{pl}'], call(G). query(a).",
    "after the mark of a script": "#!/usr/bin/env python\n:- use_module('{py}'). a. query(a).",
    "after the end of the text": "a. query(a).\x1a\n:- consult('{pl}').",
    "after a zero": "a. query(a).\x00:- consult('{pl}').",
    "as an operator of its own": ":- op(200, fy, consult). a :- consult '{pl}'. query(a).",
    "as another word for a rule": "a <- consult('{pl}'). query(a).",
    "as a grammar": "a --> consult('{pl}'), { use_module('{py}') }. query(a).",
    "in another encoding": ":- encoding(utf7). +ADoALQ- consult('{pl}'). a. query(a).",
    "as a term that is expanded": "term_expansion(a, (:- consult('{pl}'))). goal_expansion(b, consult('{pl}')). a :- b. query(a).",
}
TERMINAL = {
    "clear the screen by writing": "a :- write('\x1b[2J\x1b]0;owned\x07'), nl. query(a).",
    "clear the screen by an answer": "a('\x1b[2J\x1b]0;owned\x07'). query(a(_)).",
    "clear the screen by an error": "a :- error('\x1b[2J\x1b]52;c;b3duZWQ=\x07'). query(a).",
    "turn an answer round": "0.5::a('\u202eelbaborp\u2066', \u00e9). query(a(_, _)).",
    "write lines that look like an answer": "a('x\n       1.000   safe\n'). query(a(_)).",
    "write to the reply's channel": 'a :- writeln(\'{"answers": [[["owned", 1.0]]]}\'). 0.5::b. query(b). query(a).',
    "an atom that ends the reply": 'a(\'"}]}\n{"answers": [[["owned", 1]]]}\n\'). query(a(_)).',
    "print the clauses": "a :- dbg_printdb, print_state, debugprint(x, '{secret}'). query(a).",
    "markup of the table": "a('[link=file://{secret}]x[/link][bold]'). query(a(_)).",
    "raise by a label of letters": "'\x1b[31mred'::a. query(a).",
}
ELSEWHERE = {
    "the shell of other Prologs": "a :- shell('touch {new}'). query(a).",
    "a process of other Prologs": "a :- process_create(path(touch), ['{new}'], []). query(a).",
    "a file of other Prologs": "a :- open('{new}', write, S), write(S, x), close(S). query(a).",
    "the streams of other Prologs": "a :- see('{secret}'), read(X), seen, tell('{new}'), write(X), told. query(a).",
    "the environment of other Prologs": "a(X) :- getenv('PLOGIC_BAIT', X). query(a(_)).",
    "the flags of other Prologs": "a(X) :- current_prolog_flag(argv, X). query(a(_)).",
    "the command line": "a(X) :- cmd_args(X). query(a(_)).",
    "what runs at the start": ":- initialization(main, main). main :- shell('touch {new}'). a. query(a).",
    "what stops the process": "a :- halt(70). :- halt. query(a).",
    "what is included": ":- include('{pl}'). :- load_files(['{pl}'], [if(true)]). a :- leaked. query(a).",
    "foreign code": ":- load_foreign_library(foreign('{new}.so')). :- use_foreign_library('{new}.so'). a. query(a).",
    "Python by a bridge": "a :- py_call(os:system('touch {new}')). query(a).",
    "Python by its names": "a :- '__import__'(os), eval('open(\"{new}\", \"w\")'). query(a).",
    "Python in an expression": "a(X) :- X is '__import__(\"os\").getpid'. b(X) :- X is eval('1'). query(a(_)). query(b(_)).",
    "a function's attributes in an expression": "a(X) :- X is max('__class__', '__globals__'). query(a(_)).",
    "a format of strings": "a('{0.__class__.__init__.__globals__}%s%n$(touch {new})`touch {new}`'). query(a(_)).",
    "an unknown name that is let pass": ":- unknown(fail). a :- shell('touch {new}'). a :- consult('{pl}'). query(a).",
    "a goal that is read from text": "a :- term_to_atom(G, 'consult(\\'{pl}\\')'), call(G). query(a).",
    "a learner": "t(_)::a. :- set_flag(learn, '{new}'). query(a).",
    "a decision": "?::a. utility(a, '{secret}'). utility(b, X) :- consult('{pl}'). query(a).",
    "a distribution": "normal(0, 1)::a. X ~ normal(0, 1) :- use_module('{py}'). query(a).",
    "a sampler's file": "map_query(a). sample(a, '{new}'). 0.5::a. query(a).",
}
OVER_OURS = {
    "stand in for our goal": "'plogic goal 0' :- consult('{pl}'). 'plogic given 0'. a. query(a).",
    "stand in for a built-in": "X is Y :- consult(Y). true :- use_module('{py}'). call(X) :- consult(X). a. query(a).",
    "stand in for a library's predicate": ":- use_module(library(lists)). member(_, _) :- consult('{pl}'). a :- member(x, [x]). query(a).",
    "states that are refused": "a :- set_state(x), reset_state, check_state(x), condition(consult('{pl}')). query(a).",
}


def disguises() -> list[Hostile]:
    """Those that come as a program's file."""
    return [one for rows in (DISGUISED, TERMINAL, ELSEWHERE, OVER_OURS) for one in programs("program", rows)]
