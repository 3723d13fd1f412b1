"""Nearest misses, and what would be right."""

from __future__ import annotations

import pytest

from plogic.base.errors import InconsistentError, UnknownPredicateError
from plogic.face.session.account_text import account_text
from plogic.logic.served.engine import Text
from plogic.scene.asking.explanations import explain
from plogic.scene.asking.query import unknown_names

pytestmark = pytest.mark.usefixtures("programs_run_here")

SHOP = Text("""
open(X) :- shop(X), \\+ holiday, staff(X, S), awake(S).
open(X) :- kiosk(X).
shop(baker). shop(butcher). shop(grocer). kiosk(corner).
staff(baker, ben). staff(butcher, bea).
0.2::holiday. 0.9::awake(ben). 0.2::awake(bea).
late(X) :- hours(X, H), H > 20.
hours(baker, 18). hours(butcher, 19).
""")


def statuses(miss):
    return [(c.goal, c.kind) for c in miss.conditions]


def test_the_nearest_miss_comes_first_and_ticks_its_conditions():
    account = explain(SHOP, "open(grocer)")
    assert account.probability == 0
    first, second = account.misses
    assert (first.failed, second.failed) == (1, 1) or first.failed <= second.failed
    by_rule = {miss.rule: statuses(miss) for miss in account.misses}
    assert by_rule["open(X) :- kiosk(X)"] == [("kiosk(grocer)", "fails")]
    shop = next(kinds for rule, kinds in by_rule.items() if "shop" in rule)
    assert shop[:3] == [("shop(grocer)", "holds"), ("\\+ holiday", "possible"), ("staff(grocer, _)", "fails")]
    assert len(shop) == 4, "what an unbound variable could be is not spelt out"


def test_conditions_carry_their_probability_given_the_evidence():
    account = explain(SHOP, "open(butcher)", given=["holiday ; awake(bea)"])
    miss = account.misses[0]
    chances = {c.goal: c.probability for c in miss.conditions}
    assert chances["awake(bea)"] == pytest.approx(0.2 / 0.36)
    assert chances["\\+ holiday"] == pytest.approx(0.16 / 0.36)
    assert miss.probability == pytest.approx(account.probability) == pytest.approx(0.16 / 0.36)


def test_a_probable_goal_is_not_asked_why_not():
    assert explain(SHOP, "open(baker)").misses == ()


def test_a_negation_says_what_made_it_false():
    miss = explain(Text("dry :- \\+ wet. wet :- rain. rain."), "dry").misses[0]
    (condition,) = miss.conditions
    assert (condition.goal, condition.kind) == ("\\+ wet", "fails")
    assert [(c.goal, c.kind) for c in condition.children] == [("rain", "holds")]


def test_each_instance_is_a_miss_of_its_own():
    account = explain(SHOP, "late(X)")
    assert [m.goal for m in account.misses] == ["late(baker)", "late(butcher)"]
    assert statuses(account.misses[0]) == [("hours(baker, 18)", "holds"), ("18 > 20", "fails")]


def test_a_test_of_what_nothing_binds_is_open():
    (miss,) = explain(SHOP, "late(grocer)").misses
    assert statuses(miss) == [("hours(grocer, _)", "fails"), ("_ > 20", "open")]


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ("open", "open/1 is known"),
        ("open(a, b)", "open/1 is known"),
        ("opem(baker)", "open/1"),
        ("stuff(baker, S)", "staff/2"),
    ],
)
def test_an_unknown_predicate_is_answered_with_what_would_be_right(goal, said):
    with pytest.raises(UnknownPredicateError, match=said):
        explain(SHOP, goal)


def test_an_unknown_constant_is_answered_with_the_closest():
    assert any("baker" in note for note in explain(SHOP, "staff(bakr, S)").notes)
    assert any("unknown" in note for note in explain(SHOP, "open(bank)").notes)


def test_the_text_reads_from_the_nearest_miss_on():
    text = account_text(explain(SHOP, "open(grocer)"))
    assert text.startswith("P(open(grocer)) = 0\n")
    assert "[fails] kiosk(grocer)" in text
    assert "[ 0.8 ] \\+ holiday" in text
    assert "plogic" not in text


def test_evidence_that_is_apart_must_be_possible_too():
    program = Text("0.5::a. 0.5::b. c :- b, \\+ b. evidence(c).")
    with pytest.raises(InconsistentError):
        explain(program, "a")


PARTS = Text("""
part(h1, 'roof/apex'). part(h1, 'roof/edge'). part(h2, body). hypothesis(h1, tower). hypothesis(h2, box). 0.9::seen('roof/edge').
cause(H, F) :- claims(H, F), seen(F).
claims(H, F) :- part(H, F), hypothesis(H, _).
kind(H, T) :- hypothesis(H, T).
""")


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ("kind(X, towr)", ("towr is unknown as argument 2 of kind/2; closest are tower",)),
        ("cause(h1, roof/apex)", ("roof/apex is no name: one with a / is written in quotes, 'roof/apex'",)),
        (
            "cause(h1, 'roof/apx')",
            ("'roof/apx' is unknown as argument 2 of cause/2; closest are 'roof/apex', 'roof/edge'",),
        ),
        ("cause(h3, F)", ("h3 is unknown as argument 1 of cause/2; closest are h2, h1",)),
        ("cause(h1, 'roof/apex')", ()),
        ("cause(h1, body)", ()),
    ],
)
def test_query_and_explain_name_the_same_unknown_constants(goal, said):
    assert unknown_names(PARTS, goal) == said
    assert explain(PARTS, goal).notes == said


def test_what_anything_may_be_has_no_unknown_names():
    assert unknown_names(Text("p(X) :- X = b. p(a)."), "p(c)") == ()
