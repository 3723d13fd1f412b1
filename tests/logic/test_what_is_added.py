"""Each mistake in an author's rules is told at its file, line and column, with what would be right (§9.7)."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.base.errors import NegativeCycleError, ProgramError, UnknownPredicateError, UnsafeProgramError
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.author import author_rules
from plogic.logic.served.engine import Text, run, through
from plogic.logic.served.program_child import serve

PROGRAM = frozenset({"present/1", "object/2", "pick/2", "violated/1"})
HEADLESS = "rules.pl:2:4: a clause without a head does nothing: write constraint(name) :- "
MISTAKES = {
    "a clause without a head": ("a.\n:- present(X).", ProgramError, HEADLESS + "present(X)."),
    "a query": ("\n query(present(X)).", ProgramError, "rules.pl:2:2: query/1: rules do not ask"),
    "a head of the program's": ("present(h1).", ProgramError, "rules.pl:1:1: present/1 is defined by the program"),
    "its choices": ("0.5::pick(h1, f).", ProgramError, "rules.pl:1:6: pick/2 is defined by the program"),
    "its constraints": ("violated(me) :- a.\na.", ProgramError, "rules.pl:1:1: violated/1 is defined by the program"),
    "the law": ("unlawful.", ProgramError, "rules.pl:1:1: unlawful/0 is defined by the program"),
    "evidence on nothing": ("a.\nevidence(wet).", UnknownPredicateError, "rules.pl:2:10: no clauses for wet/0"),
    "a body of nothing": ("constraint(a) :- wet.", UnknownPredicateError, "rules.pl:1:18: no clauses for wet/0"),
    "evidence with a body": ("a.\nevidence(a) :- a.", ProgramError, "rules.pl:2:1: evidence has no body: give its condition"),
    "improbable evidence": ("a.\n0.2::evidence(a).", ProgramError, "rules.pl:2:6: evidence has no probability: give it"),
    "two in one": ("a. b.\nevidence((a, b)).", ProgramError, "rules.pl:2:1: evidence is one literal: write name :- a, b."),
    "evidence on anything": ("evidence(X).", ProgramError, "rules.pl:1:1: evidence is a literal, like"),
    "evidence of every instance": ("evidence(object(_, t)).", ProgramError, "rules.pl:1:1: evidence with variables is said of"),
    "evidence that is maybe": ("a.\nevidence(a, maybe).", ProgramError, "rules.pl:2:1: the second argument of evidence/2 is"),
    "evidence for and against": ("0.1::a.\nevidence(a).\nevidence(\\+ a).", ProgramError, "rules.pl:3:1: evidence for a and against it (line 2)"),
    "against what is said": ("0.1::a.\nevidence(a).\nevidence(a, false).", ProgramError, "rules.pl:3:1: evidence for a and against it"),
    "a constraint of no body": ("constraint(a).", ProgramError, "rules.pl:1:1: constraint(a) without a body excludes every world"),
    "a name that nothing binds": ("constraint(a(X)) :- \\+ present(X).", ProgramError, "rules.pl:1:1: X of the constraint's name is bound by"),
    "what may fail is no constraint": (
        "constraint(a(X)) :- present(X).\n0.5::constraint_may_fail(b).", ProgramError,
        "rules.pl:2:6: there is no constraint(b) that may fail; there are a(X)",
    ),
    "nothing may fail": ("0.5::constraint_may_fail(b).", ProgramError, "rules.pl:1:6: there is no constraint(b) that may fail, nor any"),
    "more than certain": ("1.5::a.", ProgramError, "rules.pl:1:1: 1.5 is not a probability: it must be from 0 to 1"),
    "less than impossible": ("-0.5::a.", ProgramError, "rules.pl:1:7: -0.5 is not a probability: it must be from 0 to 1"),
    "too much together": ("0.7::a; 0.7::b.", ProgramError, "rules.pl:1:6: the probabilities of an annotated disjunction add up to 1.4"),
    "a negative cycle": ("a :- \\+ b.\nb :- a.", NegativeCycleError, "rules.pl:1:9: a/0 depends on the negation of b/0, which depends on a/0"),
    "one of variables": (
        "a(X) :- present(X), \\+ b(X).\nb(X) :- c(X).\nc(X) :- a(X).", NegativeCycleError, "rules.pl:1:24: a/1 depends on the negation of b/1",
    ),
    "a file that is loaded": (":- use_module('x.py').", UnsafeProgramError, "rules.pl:1:4: directive use_module('x.py')"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "kind", "told"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_told_at_its_place(text, kind, told):
    with pytest.raises(kind) as caught:
        author_rules(text, Names({}, {}), PROGRAM)
    assert str(caught.value).startswith(told)


def test_all_mistakes_are_told_at_once():
    with pytest.raises(ProgramError) as caught:
        author_rules(":- present(X).\nquery(a).\n2::a.\nevidence(b).", Names({}, {}), PROGRAM)
    told = str(caught.value)
    assert all(f"rules.pl:{place}: " in told for place in ("1:4", "2:1", "3:1", "4:10")), told


@pytest.mark.parametrize("text", [
    "over(X) :- present(X), \\+ under(X).\nunder(X) :- object(X, t).",
    "win(X) :- object(X, Y), \\+ win(Y).",
    "reached(X) :- present(X).\nreached(X) :- object(X, Y), reached(Y).",
    "1.0::a.\n0.4::b; 0.6::c.\nP::d(X) :- object(X, P).",
    "constraint(X) :- object(X, t).\n0.1::constraint_may_fail(anything).",
    "constraint('A Box') :- present(X).\n0.1::constraint_may_fail(\"A Box\").",
    ":- use_module(library(lists)).\na :- member(X, [1]), X > 0.\nevidence(a, true).",
])  # fmt: skip
def test_what_may_be_said_is_not_refused(text):
    assert author_rules(text, Names({}, {}), PROGRAM)


PROBABILITIES = st.integers(0, 100).map(lambda percent: percent / 100)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(PROBABILITIES, PROBABILITIES, PROBABILITIES, PROBABILITIES)
def test_a_constraint_beside_a_program_is_conditioning(a, b, may_fail, fails):
    """By hand: of the worlds with a and b each weighs what it may fail; a constraint may be a choice itself."""
    rules = Text(f"{fails}::constraint(both) :- a, b.\n{may_fail}::constraint_may_fail(both).", "mine.pl")
    left = 1 - fails * (1 - may_fail)
    total = 1 - a * b * (1 - left)
    with through(serve):
        if total < 1e-9:
            return
        ((answer,),) = run([Text(f"{a}::a. {b}::b.", "program.pl", rules)], ["a"])
    assert answer.probability == pytest.approx((a * (1 - b) + a * b * left) / total, abs=1e-9)


def test_a_program_of_its_own_constraint_1_keeps_it():
    with through(serve), pytest.raises(ProgramError, match=r"mine\.pl:1:1: constraint/1 is defined by the program"):
        run(
            [Text("constraint(x).", "program.pl", Text("constraint(a) :- constraint(x).", "mine.pl"))],
            ["constraint(X)"],
        )
