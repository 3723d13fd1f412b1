"""ProbLog lets program text run Python and read files.

Two layers against it, each tested alone, with every trick (issues 2 and 3).
"""

from __future__ import annotations

import contextlib

import pytest

from plogic.base.errors import LimitError, PlogicError, ProgramError, UnsafeProgramError
from plogic.logic.safety.allowlist import GOALS, LIBRARIES, LOADERS, TRUSTED
from plogic.logic.safety.check import check_goal, check_source, parse
from plogic.logic.safety.guarded_engine import RefusedError, SafeEngine, engine_for
from plogic.logic.served.engine import Limits, Text, run

PYTHON, PROLOG, OWNED = "evil.py", "evil.pl", "owned"

WRITTEN = {
    "directive": ":- use_module('{py}'). a.",
    "directive with a list": ":- use_module('{py}', [x/1]). a.",
    "directive consult": ":- consult('{pl}'). a.",
    "directive as a list": ":- ['{pl}']. a.",
    "directive in a conjunction": ":- true, use_module('{py}'). a.",
    "directive that is tried": ":- try_call(use_module('{py}')). a.",
    "library by path": ":- use_module(library('{py}')). a.",
    "library upwards": ":- use_module(library('../../../../../../../../../../../../../{py}')). a.",
    "library with files": ":- use_module(library(db)). :- csv_load('{pl}', x). a.",
    "module": ":- module(m, [a/0]). a :- use_module('{py}').",
    "goal": "a :- use_module('{py}').",
    "goal consult": "a :- consult('{pl}').",
    "list as a goal": "a :- ['{pl}'].",
    "quoted functor": "a :- 'use_module'('{py}').",
    "inner name": "a :- '_use_module'(none, '{py}').",
    "inner consult": "a :- '_consult'(none, '{pl}').",
    "call of a term": "a :- call(use_module('{py}')).",
    "once": "a :- once(use_module('{py}')).",
    "try_call": "a :- try_call(use_module('{py}')).",
    "negation": "a :- \\+ use_module('{py}').",
    "double negation": "a :- \\+ \\+ use_module('{py}').",
    "not": "a :- not use_module('{py}').",
    "disjunction": "a :- fail ; use_module('{py}').",
    "forall": "a :- forall(true, use_module('{py}')).",
    "findall": "a :- findall(x, use_module('{py}'), L), L = [x].",
    "findall of findall": "a :- findall(x, findall(y, use_module('{py}'), M), L), L = [x].",
    "all": "a :- all(x, use_module('{py}'), L), L = [x].",
    "all or none": "a :- all_or_none(x, use_module('{py}'), L), L = [x].",
    "subquery": "a :- subquery(use_module('{py}'), P).",
    "subquery in scope": "a :- subquery_in_scope([], use_module('{py}'), P).",
    "call in scope": "a :- call_in_scope([], use_module('{py}')).",
    "scope": ":- use_module(library(scope)). a :- s:use_module('{py}').",
    "on_fail": ":- use_module(library(control)). a :- on_fail(fail, use_module('{py}')).",
    "assertz": ":- use_module(library(assert)). a :- assertz((b :- use_module('{py}'))), b.",
    "possible": "a :- possible(use_module('{py}')).",
    "query": "query(use_module('{py}')). a.",
    "probabilistic query": "0.5::query(use_module('{py}')). a.",
    "query in a disjunction": "0.5::b; 0.5::query(consult('{pl}')). a.",
    "evidence": "evidence(use_module('{py}')). a.",
    "evidence with a value": "evidence(consult('{pl}'), true). a.",
    "directive by its head": "'_directive' :- use_module('{py}'). a.",
    "body of a probabilistic rule": "0.9::a :- use_module('{py}').",
    "scoped rule": ":- use_module(library(scope)). s:b :- use_module('{py}'). a :- s:b.",
}
"""Attacks that the text shows."""

BUILT = {
    "call": "a :- call(use_module, '{py}').",
    "call of call": "a :- call(call, use_module, '{py}').",
    "call_nc": "a :- call_nc(use_module, '{py}').",
    "maplist": ":- use_module(library(apply)). a :- maplist(use_module, ['{py}']).",
    "univ": "a :- X =.. [use_module, '{py}'], call(X).",
    "univ, variable goal": "a :- X =.. [use_module, '{py}'], X.",
    "univ of a quoted name": "a :- X =.. ['use_module', '{py}'], call(X).",
    "univ of an inner name": "a :- X =.. ['_use_module', none, '{py}'], call(X).",
    "univ of an inner consult": "a :- X =.. ['_consult', none, '{pl}'], call(X).",
    "univ of a list": "a :- X =.. ['.', '{pl}', []], call(X).",
    "functor and arg": "a :- functor(X, use_module, 1), arg(1, X, '{py}'), call(X).",
    "call of a list": "a :- L = ['{pl}'], call(L).",
    "passed as data": "do(X) :- call(X). a :- do(use_module('{py}')).",
    "stored as data": "todo(use_module('{py}')). a :- todo(X), call(X).",
    "stored name": "name(consult). a :- name(N), call(N, '{pl}').",
    "stored file": "file('{py}'). a :- file(F), use_module(F).",
    "stored library": "file('{py}'). a :- file(F), use_module(library(F)).",
    "stored list of imports": "file('{py}'). a :- file(F), use_module(F, []).",
    "stored goal, negated": "todo(use_module('{py}')). a :- todo(X), \\+ X.",
    "stored goal, not": "todo(use_module('{py}')). a :- todo(X), not X.",
    "stored goal, tried": "todo(use_module('{py}')). a :- todo(X), try_call(X).",
    "stored goal, tried in a negation": "todo(use_module('{py}')). a :- todo(X), \\+ \\+ try_call(X).",
    "stored goal, once": "todo(use_module('{py}')). a :- todo(X), once(X).",
    "stored goal, not cached": "todo(use_module('{py}')). a :- todo(X), call_nc(X).",
    "stored goal in findall": "todo(use_module('{py}')). a :- todo(X), findall(y, X, L), L = [y].",
    "stored goal in all": "todo(use_module('{py}')). a :- todo(X), all(y, X, L), L = [y].",
    "stored goal in findall, tried": "todo(use_module('{py}')). a :- todo(X), findall(y, try_call(X), L), L = [y].",
    "stored goal in forall": "todo(use_module('{py}')). a :- forall(todo(X), X).",
    "stored goal in subquery": "todo(use_module('{py}')). a :- todo(X), subquery(X, P).",
    "stored goal in subquery, tried": "todo(use_module('{py}')). a :- todo(X), subquery(try_call(X), P).",
    "evidence of a subquery": "b. a :- subquery(b, P, [use_module('{py}')]).",
    "stored goal, possible": "todo(use_module('{py}')). a :- todo(X), possible(X).",
    "stored goal in a scope": ":- use_module(library(scope)). todo(use_module('{py}')). a :- todo(X), s:X.",
    "conjunction as data": "todo((true, use_module('{py}'))). a :- todo(X), b(X). b((P, Q)) :- call(P), call(Q).",
    "maplist of data": ":- use_module(library(apply)). file('{py}'). a :- file(F), P = use_module, maplist(P, [F]).",
    "maplist of call": ":- use_module(library(apply)). a :- maplist(call, [use_module('{py}')]).",
    "maplist of call and names": ":- use_module(library(apply)). a :- maplist(call, [use_module], ['{py}']).",
    "include of data": ":- use_module(library(apply)). p(consult). a :- p(P), include(P, ['{pl}'], _).",
    "foldl of univ": ":- use_module(library(apply)). do(X, _, _) :- Y =.. [use_module, X], call(Y). a :- foldl(do, ['{py}'], x, _).",
    "aggregate": ":- use_module(library(aggregate)). p('{py}'). load(L, x) :- X =.. [use_module | L], call(X). s(load<X>) :- p(X). a :- s(_).",
    "soft cut": ":- use_module(library(control)). a :- cut(consult, ['{pl}'], _).",
    "clause bodies": "b(use_module('{py}')). a :- clause(b(X), true), call(X).",
    "name put together": ":- use_module(library(string)). a :- concat([use, '_', module], N), X =.. [N, '{py}'], call(X).",
    "assertz of a built clause": ":- use_module(library(assert)). a :- G =.. [use_module, '{py}'], assertz((b :- G)), b.",
    "assertz of a stored clause": ":- use_module(library(assert)). c((b :- call(use_module, '{py}'))). a :- c(X), assertz(X), b.",
    "record": ":- use_module(library(record)). a :- recordz(k, use_module('{py}')), recorded(k, X), call(X).",
    "query of a variable": "query(X) :- X = use_module('{py}'). a.",
    "query from data": "todo(use_module('{py}')). query(X) :- todo(X). a.",
    "evidence from data": "todo(use_module('{py}')). evidence(X) :- todo(X). a.",
    "evidence from data, false": "todo(use_module('{py}')). evidence(X, false) :- todo(X). a.",
    "directive from data": "todo(use_module('{py}')). :- todo(X), call(X). a.",
    "directive from data, tried": "todo(use_module('{py}')). :- todo(X), try_call(X). a.",
    "negative head": "\\+b :- todo(X), call(X). b. todo(use_module('{py}')). a :- \\+ b.",
    "label by a call": "P::b :- c(P). c(0.5) :- todo(X), call(X). todo(use_module('{py}')). a :- b.",
    "csv by a built library": "l(db). :- l(X), use_module(library(X)). a.",
}
"""Attacks that only the run shows."""
ATTACKS = {**WRITTEN, **BUILT}
UNREACHED = {"module", "subquery in scope", "call in scope"}
"""Attacks that ProbLog itself never gets to: with the second layer alone only that nothing happened is tested."""
TAKEN = [
    "directive", "directive consult", "goal", "call", "findall", "univ", "univ of an inner name", "query", "evidence", "stored goal, tried",
    "stored goal in subquery", "assertz of a stored clause", "name put together", "record", "directive from data", "stored library",
]  # fmt: skip


@pytest.fixture
def bait(tmp_path):
    """Files that leave a trace when they are run or read."""
    (tmp_path / PYTHON).write_text(f"import pathlib\npathlib.Path({str(tmp_path / OWNED)!r}).write_text('x')\n")
    (tmp_path / PROLOG).write_text(f":- use_module('{tmp_path / PYTHON}').\nleaked.\n")
    return tmp_path


def baited(trick, folder):
    return ATTACKS[trick].replace("{py}", str(folder / PYTHON)).replace("{pl}", str(folder / PROLOG)) + "\nquery(a).\n"


def untouched(folder):
    return sorted(path.name for path in folder.iterdir()) == [PROLOG, PYTHON]


@pytest.mark.parametrize("trick", WRITTEN)
def test_first_layer_alone_refuses(trick, bait):
    with pytest.raises(UnsafeProgramError) as caught:
        check_source(parse(baited(trick, bait), "user.pl"))
    assert str(caught.value).startswith("user.pl:1:")
    assert untouched(bait)


@pytest.mark.parametrize("trick", ATTACKS)
def test_second_layer_alone_refuses(trick, bait):
    from problog.program import PrologString

    refused = contextlib.nullcontext() if trick in UNREACHED else pytest.raises(RefusedError)
    with refused:
        SafeEngine().ground_all(PrologString(baited(trick, bait)))
    assert untouched(bait)


@pytest.mark.parametrize("trick", ATTACKS)
def test_both_layers_refuse_as_they_are_served(trick, bait, capfd):
    from plogic.logic.served.program_child import serve

    with pytest.raises(UnsafeProgramError, match=r"user\.pl"):
        serve({"texts": [{"text": baited(trick, bait), "file": "user.pl"}], "goals": [], "given": [], "names": None})
    assert untouched(bait)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("trick", TAKEN)
def test_the_bait_is_real(trick, bait):
    """Stock ProbLog does fall for it: the tests above could fail."""
    from problog.engine import DefaultEngine
    from problog.program import PrologString

    DefaultEngine().ground_all(PrologString(baited(trick, bait)))
    assert not untouched(bait)


@pytest.mark.parametrize("trick", ["directive", "findall", "univ", "stored goal, tried"])
def test_both_layers_in_the_process_that_runs_programs(trick, bait, capfd):
    with pytest.raises(UnsafeProgramError, match=r"user\.pl:1:\d+: "):
        run([Text(baited(trick, bait), "user.pl")])
    assert untouched(bait)
    assert capfd.readouterr() == ("", "")


def test_every_built_in_of_problog_has_been_decided_on():
    """A version of ProbLog with new built-ins refuses them; this says that somebody should look."""
    from problog.engine import DefaultEngine

    refused = {signature for signature in DefaultEngine().get_builtins() if signature not in GOALS | LOADERS}
    states = {"set_state/1", "reset_state/0", "check_state/1", "condition/1", "probabilityX/1"}
    assert refused == {"consult/1", "./2"} | states


def test_every_library_of_problog_has_been_decided_on():
    from pathlib import Path

    import problog

    shipped = {path.stem for path in Path(problog.library_paths[0]).glob("*.p[ly]")}
    assert shipped - LIBRARIES == {"db", "aproblog"}


@pytest.mark.usefixtures("programs_run_here")
@pytest.mark.parametrize("library", sorted(LIBRARIES))
def test_a_pure_library_may_be_loaded(library):
    assert run([Text(f":- use_module(library({library})). 0.5::a. query(a).")])[0][0].probability == pytest.approx(0.5)


@pytest.mark.parametrize(
    "call", ["write(x)", "writeln(x, y)", "writenl(x)", "nl", "debugprint(x)", "dbg_printdb", "print_state"]
)
def test_output_is_no_part_of_the_answers(call, capfd):
    engine, db = engine_for()
    db += parse(f"a :- {call}.").statements[0]
    assert [
        str(name)
        for name, node in engine.ground(db, parse("a.").statements[0], label="query").get_names("query")
        if node == 0
    ] == ["a"]
    assert capfd.readouterr() == ("", "")


def test_what_is_refused_in_one_call_is_forgotten_in_the_next():
    engine, db = engine_for()
    for statement in parse("a :- X =.. [consult, f], try_call(X). 0.5::b.").statements:
        db += statement
    with pytest.raises(RefusedError):
        engine.ground(db, parse("a.").statements[0])
    assert [
        str(name) for name, _ in engine.ground(db, parse("b.").statements[0], label="query").get_names("query")
    ] == ["b"]


def test_all_mistakes_are_told_at_once():
    program = "a :- consult(f).\nb :- true,\n  use_module('x.py').\nlength(x, y).\n:- ['f'].\nquery(a)."
    with pytest.raises(UnsafeProgramError) as caught:
        run([Text(program, "u.pl")])
    told = str(caught.value)
    assert told.startswith("u.pl:1:6: consult/1 is not allowed")
    assert [
        place in told
        for place in ("u.pl:3:3: use_module/1", "u.pl:4:1: length/2 belongs to ProbLog", "u.pl:5:5: directive")
    ] == [True] * 3


def test_trust_lifts_the_rule(bait):
    engine, db = engine_for(trust=True, folder=str(bait))
    for statement in parse(":- use_module('evil.py'). 0.5::a.").statements:
        db += statement
    engine.prepare(db)
    assert (bait / OWNED).exists()


def test_a_trusted_program_reads_its_own_files_and_runs_its_own_python(tmp_path):
    (tmp_path / "more.pl").write_text("0.25::b.\n")
    (tmp_path / "helper.py").write_text(
        "from problog.extern import problog_export\n@problog_export('-int')\ndef seven():\n    return 7\n"
    )
    program = Text(
        ":- consult('more.pl'). :- use_module('helper.py'). a(X) :- b, seven(X). query(a(_)).",
        str(tmp_path / "program.pl"),
    )
    with pytest.raises(UnsafeProgramError):
        run([program])
    (found,) = run([program], limits=Limits(trust=True))
    assert [(answer.goal, answer.probability) for answer in found] == [("a(7)", pytest.approx(0.25))]


def test_the_limits_hold_for_trusted_programs_too():
    with pytest.raises(LimitError, match=r"longer than 0\.5 s"):
        run([Text("p(X) :- p(s(X)). query(p(1)).")], limits=Limits(seconds=0.5, trust=True))
    assert "limits of time and memory still hold" in TRUSTED


@pytest.mark.usefixtures("programs_run_here")
@pytest.mark.parametrize(
    "goal",
    ["use_module('x.py')", "X", "a, consult(x)", "\\+ consult(x)", "a :- b", "a. b", "findall(x, consult(y), L)"],
)
def test_goals_and_evidence_pass_the_same_door(goal):
    program = Text("a. b.", "user.pl")
    with pytest.raises(ProgramError, match="goal"):
        run([program], [goal])
    with pytest.raises(ProgramError, match="given"):
        run([program], ["a"], [goal])


@pytest.mark.usefixtures("programs_run_here")
@pytest.mark.parametrize(
    "goal", ["X = consult(x), call(X)", "X =.. [use_module, 'x.py'], \\+ X", "findall(y, call(consult, x), L)"]
)
def test_a_goal_that_builds_a_goal_is_refused_when_it_runs(goal):
    with pytest.raises(UnsafeProgramError, match="is not allowed"):
        run([Text("a. b.", "user.pl")], [goal])


def test_a_goal_is_checked_without_a_run():
    with pytest.raises(UnsafeProgramError, match=r"^goal:1:10: consult/1 is not allowed"):
        check_goal(parse("call(a), consult(x).", "goal"), frozenset({"a/0"}))


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
    with pytest.raises(LimitError, match=r"longer than 0\.5 s"):
        run([Text(program)], limits=Limits(seconds=0.5))


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


ENTRIES = ["query", "query of a goal", "worlds", "explain", "why not", "given"]


@pytest.mark.usefixtures("programs_run_here")
@pytest.mark.parametrize("entry", ENTRIES)
@pytest.mark.parametrize("trick", ["goal", "stored goal, tried", "directive from data", "query from data"])
def test_every_entry_passes_both_layers(entry, trick, bait):
    """Each command and verb on a program goes one of these ways.

    One that never calls the trick must leave no trace either.
    """
    from plogic.logic.served.program_worlds import program_worlds
    from plogic.scene.asking.explanations import explain
    from plogic.scene.asking.query import answers

    program = Text(baited(trick, bait), "user.pl")
    ways = {
        "query": lambda: answers(program),
        "query of a goal": lambda: answers(program, "a"),
        "worlds": lambda: program_worlds(program, 3),
        "explain": lambda: explain(program, "a"),
        "why not": lambda: explain(program, "\\+ a"),
        "given": lambda: answers(program, "a", given=["a"]),
    }
    if trick == "query from data" and entry not in ("query", "worlds"):
        with contextlib.suppress(PlogicError):
            ways[entry]()
    else:
        with pytest.raises(UnsafeProgramError):
            ways[entry]()
    assert untouched(bait)
