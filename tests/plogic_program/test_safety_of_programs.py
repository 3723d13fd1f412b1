"""ProbLog lets program text run Python and read files: two layers against it, each tested alone, with every trick (issue 2)."""

from __future__ import annotations

import contextlib

import pytest

from plogic.engine import Limits, Text, run
from plogic.errors import LimitError, PlogicError, ProgramError, UnsafeProgramError
from plogic.safety.check import check_source, parse
from plogic.safety.engine import RefusedError, SafeEngine

PYTHON, PROLOG, OWNED = "evil.py", "evil.pl", "owned"

TRICKS = {
    "directive": ":- use_module('{py}'). a.",
    "directive with a list": ":- use_module('{py}', [x/1]). a.",
    "directive consult": ":- consult('{pl}'). a.",
    "directive as a list": ":- ['{pl}']. a.",
    "initialization": ":- initialization(use_module('{py}')). a.",
    "library by path": ":- use_module(library('{py}')). a.",
    "library upwards": ":- use_module(library('../../../../../../../../{py}')). a.",
    "library with files": ":- use_module(library(db)). :- csv_load('{pl}', x). a.",
    "library of records": ":- use_module(library(record)). a.",
    "library assert": ":- use_module(library(assert)). a :- assertz(b).",
    "module": ":- module(m, [a/0]). a :- use_module('{py}').",
    "goal": "a :- use_module('{py}').",
    "goal consult": "a :- consult('{pl}').",
    "list as a goal": "a :- ['{pl}'].",
    "quoted functor": "a :- 'use_module'('{py}').",
    "inner name": "a :- '_use_module'(none, '{py}').",
    "inner consult": "a :- '_consult'(none, '{pl}').",
    "call": "a :- call(use_module, '{py}').",
    "call of a term": "a :- call(use_module('{py}')).",
    "call of call": "a :- call(call, use_module, '{py}').",
    "call of a list": "a :- L = ['{pl}'], call(L).",
    "univ": "a :- X =.. [use_module, '{py}'], call(X).",
    "univ, variable goal": "a :- X =.. [use_module, '{py}'], X.",
    "functor and arg": "a :- functor(X, use_module, 1), arg(1, X, '{py}'), call(X).",
    "passed as data": "do(X) :- call(X). a :- do(use_module('{py}')).",
    "stored as data": "todo(use_module('{py}')). a :- todo(X), call(X).",
    "once": "a :- once(use_module('{py}')).",
    "try_call": "a :- try_call(use_module('{py}')).",
    "call_nc": "a :- call_nc(use_module, '{py}').",
    "negation": "a :- \\+ use_module('{py}').",
    "double negation": "a :- \\+ \\+ use_module('{py}').",
    "not": "a :- not use_module('{py}').",
    "disjunction": "a :- fail ; use_module('{py}').",
    "forall": "a :- forall(true, use_module('{py}')).",
    "findall": "a :- findall(x, use_module('{py}'), L), L = [x].",
    "findall of findall": "a :- findall(x, findall(y, use_module('{py}'), M), L), L = [x].",
    "all": "a :- all(x, use_module('{py}'), L), L = [x].",
    "maplist": ":- use_module(library(apply)). a :- maplist(use_module, ['{py}']).",
    "foldl": ":- use_module(library(apply)). a :- foldl(use_module, ['{py}'], [], X).",
    "aggregate": ":- use_module(library(aggregate)). p('{py}'). a(use_module<X>) :- p(X). a :- a(_).",
    "subquery": "a :- subquery(use_module('{py}'), P).",
    "subquery in scope": "a :- subquery_in_scope(s, use_module('{py}'), P).",
    "call in scope": "a :- call_in_scope(s, use_module('{py}')).",
    "scope": ":- use_module(library(scope)). a :- s:use_module('{py}').",
    "possible": "a :- possible(use_module('{py}')).",
    "query": "query(use_module('{py}')). a.",
    "query of a variable": "query(X) :- X = use_module('{py}'). a.",
    "probabilistic query": "0.5::query(use_module('{py}')). a.",
    "query in a disjunction": "0.5::b; 0.5::query(consult('{pl}')). a.",
    "evidence": "evidence(use_module('{py}')). a.",
    "evidence with a value": "evidence(consult('{pl}'), true). a.",
    "directive by its head": "'_directive' :- use_module('{py}'). a.",
    "body of a probabilistic rule": "0.9::a :- use_module('{py}').",
    "redefinition": "use_module(X) :- consult(X). a :- use_module('{pl}').",
    "write": "a :- write(x).",
    "writenl": "a :- writenl(x).",
    "debugprint": "a :- debugprint(x).",
    "print database": "a :- dbg_printdb.",
    "arguments of the command": "a :- cmd_args(X).",
    "clauses": "a :- clause(a, X).",
    "trace": "a :- trace.",
    "error": "a :- error(x).",
}
HARMLESS_IN_THE_ENGINE = {"initialization", "module", "scope", "redefinition", "aggregate", "foldl"}
"""Tricks that ProbLog itself fails at in another way, or that never reach a built-in: here only that nothing happened is tested."""


@pytest.fixture
def bait(tmp_path):
    """Files that leave a trace when they are run or read."""
    (tmp_path / PYTHON).write_text(f"import pathlib\npathlib.Path({str(tmp_path / OWNED)!r}).write_text('x')\n")
    (tmp_path / PROLOG).write_text(f":- use_module('{tmp_path / PYTHON}').\nleaked.\n")
    return tmp_path


def baited(trick, folder):
    return TRICKS[trick].replace("{py}", str(folder / PYTHON)).replace("{pl}", str(folder / PROLOG)) + "\nquery(a).\n"


@pytest.mark.parametrize("trick", TRICKS)
def test_first_layer_alone_refuses(trick, bait):
    with pytest.raises(ProgramError) as caught:
        check_source(parse(baited(trick, bait), "user.pl"))
    assert str(caught.value).startswith("user.pl:1:")
    assert not (bait / OWNED).exists()


@pytest.mark.parametrize("trick", TRICKS)
def test_second_layer_alone_refuses(trick, bait):
    from problog.errors import ProbLogError
    from problog.program import PrologString

    refused = contextlib.suppress(ProbLogError) if trick in HARMLESS_IN_THE_ENGINE else pytest.raises(RefusedError)
    with refused:
        SafeEngine().ground_all(PrologString(baited(trick, bait)))
    assert not (bait / OWNED).exists()


@pytest.mark.parametrize("trick", ["directive", "findall", "univ", "query"])
def test_the_bait_is_real(trick, bait):
    """Stock ProbLog does fall for it: the tests above could fail."""
    from problog.engine import DefaultEngine
    from problog.program import PrologString

    DefaultEngine().ground_all(PrologString(baited(trick, bait)))
    assert (bait / OWNED).exists()


@pytest.mark.parametrize("trick", ["directive", "findall", "write"])
def test_both_layers_in_the_process_that_runs_programs(trick, bait, capfd):
    with pytest.raises(UnsafeProgramError, match=r"user\.pl:1:\d+: "):
        run([Text(baited(trick, bait), "user.pl")])
    assert not (bait / OWNED).exists()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "goal", ["use_module('x.py')", "X", "call(X)", "a, consult(x)", "\\+ consult(x)", "a :- b", "a. b", "findall(x, consult(y), L)"]
)
def test_goals_and_evidence_pass_the_same_door(goal):
    program = Text("a. b.", "user.pl")
    with pytest.raises(ProgramError, match="goal"):
        run([program], [goal])
    with pytest.raises(ProgramError, match="given"):
        run([program], ["a"], [goal])


def test_pure_libraries_work():
    program = """
        :- use_module(library(lists)). :- use_module(library(apply)). :- use_module(library(aggregate)).
        p(1). p(2). 0.5::q(X) :- member(X, [1, 2]). r(X) :- maplist(p, [X, X]), q(X). total(sum<X>) :- p(X). both :- forall(p(X), q(X)).
        query(r(_)). query(total(_)). query(both).
    """
    answers = {a.goal: a.probability for a in run([Text(program)])[0]}
    assert answers == pytest.approx({"total(3)": 1.0, "r(1)": 0.5, "r(2)": 0.5, "both": 0.25})


@pytest.mark.parametrize("program", ["p(X) :- p(s(X)). query(p(1)).", "p(X) :- Y is X + 1, p(Y). query(p(1))."])
def test_wall_time_is_limited(program):
    with pytest.raises(LimitError, match="longer than 1 s"):
        run([Text(program)], limits=Limits(seconds=1))


def test_memory_is_limited():
    with pytest.raises(LimitError, match="512 MB"):
        run([Text("p(L) :- length(L, 100000000). query(p(_)).")], limits=Limits(megabytes=512))


DEEP = 3000


@pytest.mark.parametrize(
    "program",
    [
        "a(" * DEEP + "b" + ")" * DEEP + ".",
        "a :- " + "\\+ " * DEEP + "b. b.",
        "a :- " + "(" * DEEP + "b" + ")" * DEEP + ". b.",
        "a([" + ",".join("x" for _ in range(DEEP)) + "]). query(a(_)).",
        "a(\x00).",
        "a('\ud7ff\u2028').",
        "é(X) :- X.",
    ],
)
def test_no_program_gets_a_traceback(program):
    try:
        run([Text(program + " query(c). c.")], limits=Limits(seconds=20))
    except PlogicError as error:
        assert "Traceback" not in str(error)  # noqa: PT017 - an answer is as good as a clear error
        assert "\n" not in str(error)  # noqa: PT017
