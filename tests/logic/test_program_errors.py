"""Mistakes in programs: each is told with file, line and column, a cycle is spelt out, all of a kind come at once."""

from __future__ import annotations

import pytest

from plogic.base.errors import (
    InconsistentError,
    LimitError,
    NegativeCycleError,
    NonGroundError,
    ProgramError,
    UnknownPredicateError,
)
from plogic.logic.safety.recursion import endless, surely_endless
from plogic.logic.served.engine import Limits, Text, run
from plogic.logic.served.program_child import reply_to, serve


def asked(*texts, goals=()):
    items = [{"text": text, "file": file} for file, text in zip(("u.pl", "more.pl"), texts, strict=False)]
    return serve({"texts": items, "goals": list(goals), "given": [], "names": None})["answers"]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("evidence().", "1:1: evidence"),
        ("a :- b, c( ).", "1:9: c"),
        ("p()::a.", "1:1: p"),
        ("a(f(g())). query(a(_)).", "1:5: g"),
    ],
)
def test_brackets_with_nothing_in_them_are_told(text, place):
    assert f"u.pl:{place}() has brackets with nothing in them" in told(ProgramError, f"{text} 0.5::wet. query(wet).")


@pytest.mark.parametrize("label", ["1e-16", "1.0e-300", "0.00000000000000000001"])
def test_a_label_that_problog_would_read_as_none_is_told(label):
    for text in (f"{label}::rare. query(rare).", f"0.3::a; {label}::rare. query(a)."):
        assert f"{label} is 0 to ProbLog" in told(ProgramError, text)


@pytest.mark.parametrize("label", ["0.0", "0", "1e-15", "0.0e5"])
def test_a_label_of_nothing_is_one(label):
    assert asked(f"{label}::a. 0.5::b. query(b).")


def told(kind, *texts, goals=()):
    with pytest.raises(kind) as caught:
        asked(*texts, goals=goals)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    "clause",
    [
        "fact(N, F) :- M is N - 1, fact(M, G), F is N * G.",
        "0.5::up(N) :- M is 1 + N, up(M).",
        "wrapped(X) :- wrapped(f(X)).",
        "0.5::a(N); 0.5::b(N) :- M is N + 2, a(M).",
    ],
)
def test_a_call_that_nothing_can_stop_is_told_before_any_run(clause):
    (line,) = surely_endless(f"fact(0, 1).\n{clause}", "u.pl")
    assert line.startswith("u.pl:2:")
    assert "calls itself without end, whatever it is asked" in line


@pytest.mark.parametrize(
    "clause",
    [
        "n(N) :- N > 0, M is N - 1, n(M).",
        "len([_ | T], N) :- len(T, M), N is M + 1.",
        "up(N, [_ | T]) :- M is N + 1, up(M, T).",
        "path(X, N) :- edge(X, Y), M is N + 1, path(Y, M).",
        "half(N) :- M is N // 2, half(M).",
        "same(N) :- M is N + 0, same(M).",
        "left(X, Y) :- left(X, Z), edge(Z, Y).",
        "turned(X, Y) :- turned(Y, X).",
        "maybe(X) :- seen(X) ; maybe(f(X)).",
        "n(N) :- M is N - ",
    ],
)
def test_what_may_end_is_no_such_call(clause):
    assert surely_endless(clause, "u.pl") == []


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("a.\nb('1', % 2\n  NINES).", "u.pl:3:3: holds a whole number of more digits than can be read"),
        ("NINES::b.", "u.pl:1:1: holds a whole number of more digits than can be read"),
    ],
)
def test_a_number_of_too_many_digits_has_a_place(program, message):
    assert told(ProgramError, program.replace("NINES", "9" * 5000)) == message


def test_a_number_that_becomes_too_large_is_told_in_words():
    texts = [{"text": "b(X) :- X is 10**5000.\nquery(b(X)).", "file": "u.pl"}]
    reply = reply_to({"texts": texts, "goals": [], "given": [], "names": None})
    assert "a number gets more digits than can be written" in reply["error"]["reason"]


CYCLES = {
    "a :- \\+ b.\nb :- \\+ a.\nquery(a).": "u.pl:2:6: a negation depends on itself (negative cycle): b :- \\+ a (u.pl:2), a :- \\+ b (u.pl:1)",
    "0.5::t.\na :- t,\n     \\+ a.\nquery(a).": "u.pl:3:6: a negation depends on itself (negative cycle): a :- \\+ a (u.pl:3)",
    "a :- b.\nb :- c, t.\n0.5::t.\nc :- \\+ a.\nquery(a).": (
        "u.pl:4:6: a negation depends on itself (negative cycle): c :- \\+ a (u.pl:4), a :- b (u.pl:1), b :- c (u.pl:2)"
    ),
    "win(X) :- move(X, Y), \\+ win(Y).\nmove(1, 2). move(2, 1).\nquery(win(1)).": (
        "u.pl:1:23: a negation depends on itself (negative cycle): win(X) :- \\+ win(Y) (u.pl:1)"
    ),
    "0.5::a; 0.2::b :- not c.\nc :- x ; a.\n0.5::x.\nquery(c).": (
        "u.pl:1:19: a negation depends on itself (negative cycle): a :- not c (u.pl:1), c :- a (u.pl:2)"
    ),
    "a :- \\+ (t, b).\n0.5::t.\nb :- a.\nquery(a).": (
        "u.pl:1:6: a negation depends on itself (negative cycle): a :- \\+ (t, b) (u.pl:1), b :- a (u.pl:3)"
    ),
}


@pytest.mark.parametrize("program", CYCLES)
def test_a_negative_cycle_is_spelt_out(program):
    assert told(NegativeCycleError, program) == CYCLES[program]


def test_a_cycle_through_a_variable_goal_has_a_place_at_least():
    message = told(NegativeCycleError, "0.5::t.\na :- t, G = b, \\+ G.\nb :- H = a, call(H).\nquery(a).")
    assert message == "u.pl:2:16: a negation depends on itself (negative cycle)"


def test_a_collection_that_depends_on_itself_is_spelt_out():
    message = told(ProgramError, "p(1).\nq(X) :- r(X).\nr(X) :- findall(Y, q(Y), L), p(X).\nquery(q(1)).")
    assert message.startswith("u.pl:3:9: a goal that collects answers (findall/3, all/3) depends on itself: ")
    assert message.endswith("r(X) :- findall(Y,q(Y),L) (u.pl:3), q(X) :- r(X) (u.pl:2)")


def test_all_unknown_predicates_are_told_at_once():
    message = told(
        UnknownPredicateError, "a :- b, nothing(1).\n0.5::b :- \\+ missing.\nc :- absent(X), member(X, [1]).\nquery(a)."
    )
    assert message == (
        "u.pl:2:14: no clauses for missing/0; also u.pl:1:9: no clauses for nothing/1; also u.pl:3:6: no clauses for absent/1"
        "; also u.pl:3:17: no clauses for member/2 (:- use_module(library(lists)) would define it)"
    )


UNKNOWN = {
    "a :- !.": "no clauses for !/0 (ProbLog has no cut",
    "a :- (b -> c ; d). b.": "no clauses for ->/2 (ProbLog has no if-then-else",
    "a :- append(X, [1], [1]).": "no clauses for append/3 (:- use_module(library(lists)) would define it)",
    "a :- concat([x], X).": "no clauses for concat/2 (:- use_module(library(string)) would define it)",
    "a :- call(zork, 1).": "no clauses for zork/1",
    ":- dynamic(a/1). a.": "no clauses for dynamic/1",
}


@pytest.mark.parametrize("program", UNKNOWN)
def test_an_unknown_predicate_comes_with_a_hint_where_there_is_one(program):
    assert UNKNOWN[program] in told(UnknownPredicateError, f"{program}\nquery(a).")


def test_what_is_never_called_may_be_unknown():
    assert asked("a :- fail, nothing(1). b :- nothing(2). 0.5::c. query(c). query(a).") == [[("c", 0.5), ("a", 0.0)]]


NOT_GROUND = {
    "0.5::a(X).\nquery(a(_)).": "u.pl:1:6: 0.5::a(X) is a choice that keeps X open",
    "p(1).\n0.5::a(X, Y) :- p(X).\nquery(a(1, _)).": "u.pl:2:6: 0.5::a(X,Y) is a choice that keeps Y open",
    "P::a :- q(X).\nq(1).\nquery(a).": "u.pl:1:4: P::a is a choice that keeps P open",
    "0.3::a.\nb(X) :- a.\nquery(b(_)).": "u.pl:3:7: the goal keeps a variable that nothing binds",
}


@pytest.mark.parametrize("program", NOT_GROUND)
def test_a_choice_or_a_goal_that_is_not_ground_names_its_variables(program):
    assert told(NonGroundError, program).startswith(NOT_GROUND[program])


def test_errors_name_the_file_that_they_are_in():
    assert told(ProgramError, "a.", "b :- true,\n  nothing.", goals=["b"]).startswith(
        "more.pl:2:3: no clauses for nothing/0"
    )
    assert told(ProgramError, "a.", "a :- b. b.", goals=["a"]).startswith("more.pl:1:1: a/0 is defined by the program")
    assert told(ProgramError, "a.", "b :- (c.", goals=["b"]).startswith("more.pl:1:6: Unmatched")


@pytest.mark.parametrize("goal", ["zork(1)", "a, zork(1)"])
def test_a_goal_that_nothing_defines_is_told_without_a_run(goal):
    assert told(UnknownPredicateError, "a.", goals=[goal]).startswith("goal:1:")
    assert asked(":- use_module(library(assert)). :- assertz(zork(1)). a.", goals=[goal])[0][0][1] == 1.0


@pytest.mark.parametrize(
    "program", ["0.3::a. evidence(a). evidence(\\+ a).", "a :- fail. evidence(a). 0.5::b. query(b)."]
)
def test_impossible_evidence_is_no_mistake_of_the_program(program):
    assert told(InconsistentError, program) == "no world satisfies the evidence: its probability is 0"


@pytest.mark.parametrize(
    "program", ["a :- try_call(b, 1). query(a).", "a; b :- c. c. query(a).", "a :- varnumbers(1, X). query(a)."]
)
def test_what_problog_stumbles_over_is_one_clear_line(program):
    assert told(ProgramError, program).startswith("u.pl")


def test_evidence_may_rule_out_the_clause_that_is_not_ground():
    """As ProbLog's command line has it: what contradicts the evidence is not grounded."""
    program = "0.4::a. 0.3::b(X) :- a. c :- b(_). 0.5::d. evidence(\\+ a). query(d). query(c)."
    assert dict(asked(program)[0]) == pytest.approx({"d": 0.5, "c": 0.0})


def test_a_goal_that_fails_in_the_run_is_told_where_it_stands():
    program = "a(0).\nb(X) :- a(X)."
    assert told(ProgramError, program, goals=["b(X), Y is 1 / X"]).startswith("goal:1:9: Error while evaluating")
    assert told(
        ProgramError, program, "c(X) :- b(X).\nd(Y) :- c(X),\n  Y is 1 / X.", goals=["a(0)", "d(Y)"]
    ).startswith("more.pl:3:5: Error")


CLOSE = {
    "0.4::heads1.\ntwo :- head1.\nquery(two).": "u.pl:2:8: no clauses for head1/0; the closest that is known: heads1/0",
    "0.4::edge(1,2).\np(X) :- edge(X,_,_).\nquery(p(1)).": "u.pl:2:9: no clauses for edge/3; edge/2 is known",
}


@pytest.mark.parametrize("program", CLOSE)
def test_the_closest_predicate_is_named(program):
    assert told(UnknownPredicateError, program) == CLOSE[program]


def test_a_goals_predicate_has_its_closest_too():
    reason = told(UnknownPredicateError, "0.4::heads1.", goals=["heads"])
    assert reason == "goal:1:1: no clauses for heads/0; the closest that is known: heads1/0"


LABELS = {
    "c.\n0.6::a; 0.7::b.\nquery(a).": "u.pl:2:6: the probabilities of an annotated disjunction add up to 1.3: they must not",
    "c.\n0.6::a; 0.7::b :- d.\nd :- fail.\nquery(c).": "u.pl:2:6: the probabilities of an annotated disjunction add up to",
    "c.\nt(_)::p.\nquery(c).": "u.pl:2:1: t(_) is not a probability: it is to be learned",
    "c.\n?::u.\nquery(c).": "u.pl:2:1: ? is not a probability: it is a decision",
    "c.\nnormal(0,1)::x.\nquery(c).": "u.pl:2:1: normal(0,1) is not a probability: it is a distribution",
    "c.\n9 ** (9 ** (9 ** 9))::x.\nquery(c).": "u.pl:2:3: 9**(9**(9**9)) is not a probability: it holds a number of more",
}


def test_powers_that_are_probabilities_are_worked_out():
    program = "2 ** (-3)::a. 0.5 ** 2::b. 1 / (2 ^ 3000)::c. (1 << 2) / 8::d. 1 ** (1 << 40)::e. query(a). query(b)."
    more = " query(c). query(d). query(e)."
    (answers,) = run([Text(program + more)], [])
    found = {answer.goal: answer.probability for answer in answers}
    assert found == pytest.approx({"a": 0.125, "b": 0.25, "c": 0.0, "d": 0.5, "e": 1.0})


@pytest.mark.parametrize("program", LABELS)
def test_a_label_that_is_no_probability_is_told_whatever_is_asked(program):
    assert told(ProgramError, program).startswith(LABELS[program])


@pytest.mark.parametrize(
    "program",
    ["0.5::a; 0.5::b.\nquery(a).", "1/2::a; 1/2::b.\nquery(a).", "P::a; Q::b :- P = 0.5, Q = 0.5.\nquery(a)."],
)
def test_what_adds_up_to_1_is_a_disjunction(program):
    assert asked(program) == [[("a", 0.5)]]


def test_a_continuous_variable_is_said_to_be_none_of_plogics():
    assert "choices of plogic are discrete" in told(UnknownPredicateError, "x(X) :- X ~ normal(0,1).\nquery(x(_)).")


def reason_of(text, given=()):
    return reply_to({"texts": [{"text": text, "file": "u.pl"}], "goals": ["a"], "given": list(given), "names": None})[
        "error"
    ]["reason"]


@pytest.mark.parametrize(
    ("program", "given", "said"),
    [
        ("0.5::a.\nb :- a, \\+ a.\nevidence(b).", (), "; evidence(b) (u.pl:3) alone is impossible"),
        (
            "0.5::a.\n0.5::b.\nevidence(b).\nevidence(a).\nevidence(\\+ a).",
            (),
            "; evidence(a) (u.pl:4) and evidence(\\+ a) (u.pl:5) exclude each other",
        ),
        ("0.5::a.\nevidence(a, false).", ("a",), "; evidence(a, false) (u.pl:2) and --given a exclude each other"),
        (
            "0.5::a.\n0.5::b.\nc :- \\+ a.\nc :- \\+ b.\nevidence(a).\nevidence(b).\nevidence(c).",
            (),
            "its probability is 0",
        ),
    ],
)
def test_impossible_evidence_is_named(program, given, said):
    assert reason_of(program, given).endswith(said)


def test_a_recursion_without_end_is_named_beside_the_limit():
    program = Text("even(0).\neven(N) :- M is N+2,\n           even(M).\n", "u.pl")
    with pytest.raises(LimitError) as caught:
        run([program], ["even(1)"], limits=Limits(seconds=3))
    assert str(caught.value) == (
        "the inference took longer than 3 s; recursion without end? even/1 calls itself: even(M) (u.pl:3:12)"
    )


@pytest.mark.parametrize(
    ("program", "goal", "said"),
    [
        (
            "n(X) :- m(s(X)).\nm(X) :- n(X).",
            "n(0)",
            "recursion without end? n/1 calls itself by way of m/1: m(s(X)) (u.pl:1:9)",
        ),
        ("path(X, Y) :- path(X, Z), edge(Z, Y).\npath(X, X).\nedge(1, 2).", "path(1, Y)", ""),
        ("length_of([], 0).\nlength_of([_|T], N) :- length_of(T, M), N is M+1.", "length_of([a], N)", ""),
        ("up(N) :- M is N+1, up(M).\nother(1).", "other(X)", ""),
        ("up(N) :- M is N+1, up(M).\nquery(up(0)).", "", "recursion without end? up/1 calls itself: up(M) (u.pl:1:20)"),
    ],
    ids=["by way of another", "answered from a table", "what grows smaller", "not asked for", "by a query of its own"],
)
def test_a_recursion_is_suspected_where_what_is_asked_calls_itself_with_more(program, goal, said):
    assert endless([{"text": program, "file": "u.pl"}], [goal] if goal else []) == said


@pytest.mark.parametrize(
    "label", ["9 ** (9 ** (9 ** 9))", "9 ^ (9 ^ (9 ^ 9))", "1 << (1 << 60)", "1 / (3 + 2 ** (2 ** 40))"]
)
def test_a_label_whose_value_would_be_long_is_told_and_not_worked_out(label):
    from plogic.logic.safety.check import check_source, parse

    with pytest.raises(
        ProgramError, match=r"^u\.pl:1:3: .* is not a probability: it holds a number of more than 10000 "
    ):
        check_source(parse(f"{label}::a.", "u.pl"))


def test_a_power_of_what_only_a_run_can_tell_is_left_to_it():
    from plogic.logic.safety.check import check_source, parse

    assert check_source(parse("X ** (9 ** 9)::a(X) :- b(X). b(0.5).", "u.pl")) == {"a/1", "b/1"}


def test_quotes_that_are_never_closed_are_looked_through_once():
    from plogic.logic.safety.check import parse

    with pytest.raises(ProgramError, match=r"u\.pl:1:3: holds a whole number of more digits"):
        parse("a(" + "9" * 5000 + ").\nb('" + "\\'" * 500_000, "u.pl")
