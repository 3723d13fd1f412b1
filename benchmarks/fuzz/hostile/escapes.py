"""Programs that try to load, run or read something, by what is written in them or by what they build as they run."""

from __future__ import annotations

from benchmarks.fuzz.hostile.program import Hostile, programs

LOADING = {
    "load Python by a directive": ":- use_module('{py}'). a. query(a).",
    "load Python and import by name": ":- use_module('{py}', [owned/1]). a. query(a).",
    "consult a program": ":- consult('{pl}'). a :- leaked. query(a).",
    "consult a list of programs": ":- ['{pl}', '{py}']. a. query(a).",
    "consult as a list's cell": ":- '.'('{pl}', []). a. query(a).",
    "consult a secret as a program": ":- consult('{secret}'). a(X) :- token(X). query(a(_)).",
    "consult a folder": ":- consult('{secret_folder}'). a. query(a).",
    "consult standard input": ":- consult(user). a. query(a).",
    "consult a device": ":- consult('/dev/stdin'). a. query(a).",
    "consult the process itself": ":- consult('/proc/self/environ'). a. query(a).",
    "load by a URL": ":- use_module('file://{py}'). a. query(a).",
    "load from the network": ":- consult('http://127.0.0.1:9/x.pl'). a. query(a).",
    "climb out of the library": ":- use_module(library('../../../../../../../../../../../..{py}')). a. query(a).",
    "a library of an absolute path": ":- use_module(library('{py}')). a. query(a).",
    "a library's private Python": ":- use_module(library('nlp4plp.d/../../engine.py')). a. query(a).",
    "a library's file under a trailing dot": ":- use_module(library('lists.py/.')). a. query(a).",
    "the library that reads tables": ":- use_module(library(db)). :- csv_load('{csv}', row). a(X) :- row(X, _). query(a(_)).",
    "the library that opens databases": ":- use_module(library(db)). :- sqlite_load('{db}'). a(X) :- t(X). query(a(_)).",
    "the library that replaces the semiring": (
        ":- use_module(library(aproblog)). :- use_semiring(plus, times, zero, one, true, true). 0.5::a. query(a)."
    ),
    "the inner loader": "a :- '_use_module'(none, '{py}'). query(a).",
    "the inner reader": "a :- '_consult'(none, '{pl}'), leaked. query(a).",
    "a module of the same name as a library": ":- module(lists, [a/0]). a :- lists:use_module('{py}'). query(a).",
    "load where a negation hides it": "a :- \\+ \\+ consult('{pl}'). query(a).",
    "load while it is asked": "query(use_module('{py}')). a.",
    "load while it is observed": "evidence(consult('{pl}'), false). 0.5::a. query(a).",
    "load in a label": "P::a :- consult('{pl}'), P = 0.5. query(a).",
    "load in one head of a choice": "0.5::b; 0.5::query(consult('{pl}')). a.",
    "a directive's own name as a head": "'_directive' :- use_module('{py}'). a. query(a).",
}
"""They name the loader."""
BUILT = {
    "a loader from its letters": (
        ":- use_module(library(string)). a :- concat([c, o, n, s, u, l, t], N), call(N, '{pl}'). query(a)."
    ),
    "a loader joined from a list": (
        ":- use_module(library(string)). a :- join('_', [use, module], N), G =.. [N, '{py}'], call(G). query(a)."
    ),
    "a loader from a string taken apart": (
        ":- use_module(library(string)). a :- str2lst(consult, L), lst2str(L, N), G =.. [N, '{pl}'], G. query(a)."
    ),
    "a loader by functor and arg": "a :- functor(G, use_module, 1), arg(1, G, '{py}'), call(G). query(a).",
    "a loader in a fact": "todo(consult('{pl}')). a :- todo(G), call(G). query(a).",
    "a loader in a probable fact": "0.5::todo(consult('{pl}')). a :- todo(G), call(G). query(a).",
    "a loader among a choice's heads": "0.3::todo(true); 0.3::todo(use_module('{py}')). a :- todo(G), G. query(a).",
    "a loader passed through four predicates": (
        "p(G) :- q(G). q(G) :- r(f(G)). r(f(G)) :- s([G]). s([G]) :- once(G). a :- p(consult('{pl}')). query(a)."
    ),
    "a loader swallowed by try_call": "todo(use_module('{py}')). a :- todo(G), \\+ \\+ try_call(G). query(a).",
    "a loader over a list": ":- use_module(library(apply)). n(consult). a :- n(N), maplist(N, ['{pl}', '{pl}']). query(a).",
    "a loader folded over a list": (
        ":- use_module(library(apply)). do(F, _, _) :- G =.. [use_module, F], call(G). a :- foldl(do, ['{py}'], x, _). query(a)."
    ),
    "a loader as a filter": ":- use_module(library(apply)). p(consult). a :- p(P), exclude(P, ['{pl}'], _). query(a).",
    "a loader while answers are collected": "f('{pl}'). a :- findall(x, (f(F), G =.. [consult, F], G), L), L = [x]. query(a).",
    "a loader in an aggregate": (
        ":- use_module(library(aggregate)). f('{py}'). go(L, 1) :- G =.. [use_module|L], G. s(go<X>) :- f(X). a :- s(_). query(a)."
    ),
    "a loader in a subquery": "todo(consult('{pl}')). a :- todo(G), subquery(G, P), P > 0. query(a).",
    "a loader as a subquery's evidence": "0.5::b. todo(consult('{pl}')). a :- todo(G), subquery(b, P, [G]). query(a).",
    "a program of somebody else's in a subquery": 'a :- subquery(b, P, [], semiring, "{py}"). b. query(a).',
    "a compiler named by the program": 'b. a :- subquery(b, P, [], prob, "kbest"). query(a).',
    "a loader added to the program": (
        ":- use_module(library(assert)). a :- G =.. [use_module, '{py}'], assertz((b :- G)), b. query(a)."
    ),
    "a directive added to the program": (
        ":- use_module(library(assert)). a :- assertz((:- consult('{pl}'))), b. b. query(a)."
    ),
    "a loader kept in a record": (
        ":- use_module(library(record)). a :- recordz(k, consult('{pl}')), recorded(k, G), call(G). query(a)."
    ),
    "the Python object behind a record": (
        ":- use_module(library(record)). a :- recordz(k, v, R), R =.. L, L = [F|_], G =.. [F, '{pl}'], call(G). query(a)."
    ),
    "a method of a name": ":- use_module(library(record)). a :- erase('{new}'), instance('__class__', X). query(a).",
    "a loader from a clause's body": "b(consult('{pl}')) :- true. a :- clause(b(G), true), call(G). query(a).",
    "the names of built-ins from the clauses": "a :- clause(H, B), call(H, '{pl}'), call(B). query(a).",
    "a loader in a scope": ":- use_module(library(scope)). g(consult('{pl}')). a :- g(G), s:G. query(a).",
    "a loader where something fails": ":- use_module(library(control)). g(consult('{pl}')). a :- g(G), on_fail(fail, G). query(a).",
    "a loader by a soft cut": ":- use_module(library(cut)). r(1) :- G =.. [consult, '{pl}'], G. a :- cut(r). query(a).",
    "a collector's name put together": (
        ":- use_module(library(collect)). collect_x(_, _, F) :- G =.. [consult, F], G. a :- (true => x('{pl}')). query(a)."
    ),
    "the file's name through twenty predicates": (
        "".join(f"f{i}(X) :- f{i + 1}(X). " for i in range(20)) + "f20('{py}'). a :- f0(F), use_module(F). query(a)."
    ),
    "a library's name decided by chance": "0.5::l(lists); 0.5::l('{py}'). a :- l(L), use_module(library(L)). query(a).",
    "code in an error's message": "a :- error('{secret}', consult('{pl}')). query(a).",
}
"""They build it."""


def escapes() -> list[Hostile]:
    """Those that come as a program's file."""
    return programs("program", LOADING) + programs("program", BUILT)
