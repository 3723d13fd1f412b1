"""Oracle: stock ProbLog.

Every explanation entails its goal, loses that with any choice less, and is as probable as it says.
"""

from __future__ import annotations

import pytest

from plogic.logic.served.engine import Text, run
from plogic.scene.asking.explanations import explain
from plogic.scene.asking.query import answers

pytestmark = pytest.mark.usefixtures("programs_run_here")

ALARM = """
0.1::burglary. 0.2::earthquake.
0.95::alarm :- burglary, earthquake. 0.94::alarm :- burglary, \\+ earthquake. 0.29::alarm :- \\+ burglary, earthquake.
0.9::calls(john). 0.7::calls(mary).
rings(X) :- alarm, calls(X).
"""
FRIENDS = """
0.3::stress(ann). 0.3::stress(bob). 0.4::stress(cid).
0.2::influences(X, Y) :- friend(X, Y).
smokes(X) :- stress(X). smokes(X) :- influences(Y, X), smokes(Y).
friend(ann, bob). friend(bob, ann). friend(bob, cid). friend(cid, ann).
"""
DICE = """
1/6::die(D,1); 1/6::die(D,2); 1/6::die(D,3); 1/6::die(D,4); 1/6::die(D,5); 1/6::die(D,6) :- d(D).
d(a). d(b). total(S) :- die(a, X), die(b, Y), S is X + Y. high :- total(S), S > 9. double :- die(a, X), die(b, X).
"""
LISTS = """
:- use_module(library(lists)).
0.5::has(X) :- member(X, [a, b, c]). w(a, 1). w(b, 2). w(c, 3).
sum(T) :- findall(W, (has(X), w(X, W)), L), sum_list(L, T). rich :- sum(T), T >= 4.
light(X) :- w(X, W), W < 3. all_light :- forall(has(X), light(X)). odd :- (has(a) ; has(c)), \\+ (has(a), has(c)).
"""
CASES = [
    (ALARM, "burglary", ["rings(john)"]),
    (ALARM, "rings(X)", []),
    (ALARM, "\\+ alarm", ["calls(mary)"]),
    (FRIENDS, "smokes(ann)", []),
    (FRIENDS, "smokes(cid), \\+ stress(cid)", ["smokes(ann)"]),
    (DICE, "total(11)", []),
    (DICE, "high", ["die(a, 6)"]),
    (DICE, "high ; double", ["\\+ die(b, 3)"]),
    (LISTS, "rich", []),
    (LISTS, "all_light", []),
    (LISTS, "odd", ["has(b)"]),
]


def chances(program, goals, given=()):
    return [found[0].probability for found in run([Text(program)], goals, list(given))]


def conjunction(choices):
    return ", ".join(choices) if choices else "true"


@pytest.mark.parametrize(("program", "goal", "given"), CASES, ids=lambda value: str(value)[:20].strip())
def test_each_explanation_by_stock_problog(program, goal, given):
    account = explain(Text(program), goal, given=given, most=3)
    explained = [e for e in (*account.why, *account.why_not) if not any(" :- " in choice for choice in e.choices)]
    assert explained
    weighed = chances(program, [goal, *(conjunction(e.choices) for e in explained)], given)
    best = max(found.probability for found in run([Text(program)], [goal], given)[0])
    assert account.probability == pytest.approx(best, abs=1e-9)
    assert [e.given_evidence for e in explained] == pytest.approx(weighed[1:], abs=1e-9)
    sets = [(e.goal, e.choices) for e in explained]
    fewer = [(shown, (*choices[:i], *choices[i + 1 :])) for shown, choices in sets for i in range(len(choices))]
    asked = [
        g for shown, choices in (*sets, *fewer) for g in (conjunction(choices), f"{conjunction(choices)}, ({shown})")
    ]
    found = chances(program, asked)
    entailed = [with_goal / alone for alone, with_goal in zip(found[::2], found[1::2], strict=True)]
    assert entailed[: len(sets)] == pytest.approx([1.0] * len(sets)), "it entails the goal"
    assert all(p < 1 - 1e-9 for p in entailed[len(sets) :]), "and no choice is superfluous"


@pytest.mark.parametrize(("program", "goal", "given"), CASES, ids=lambda value: str(value)[:20].strip())
def test_they_are_ranked_by_what_the_evidence_leaves_of_them(program, goal, given):
    account = explain(Text(program), goal, given=given, most=4)
    for listed, covered in ((account.why, account.covered), (account.why_not, account.covered_not)):
        ranked = [e.given_evidence for e in listed]
        assert ranked == sorted(ranked, reverse=True)
        assert all(x > 0 for x in ranked), "none contradicts the evidence"
        assert covered.listed[0] <= covered.listed[1] + 1e-12
        assert max(ranked, default=0.0) <= covered.listed[1] + 1e-9


def test_what_shares_a_head_is_told_with_its_clause():
    choices = {c for e in explain(Text(ALARM), "alarm").why for c in e.choices}
    assert "alarm :- burglary, earthquake" in choices
    assert "calls(john)" in {c for e in explain(Text(ALARM), "rings(john)").why for c in e.choices}


def test_evidence_that_hangs_together_in_a_chain_counts():
    """The goal shares a choice with the first observation alone, that with the second, and so on."""
    links = "".join(
        f"l{x}{y} :- {x}. l{x}{y} :- \\+ {y}. evidence(l{x}{y}).\n" for x, y in ("ab", "bc", "cd", "de", "ef")
    )
    program = Text("0.3::a. 0.4::b. 0.5::c. 0.2::d. 0.6::e. 0.9::f.\n" + links)
    (answer,) = answers(program, "a")
    assert explain(program, "a").probability == pytest.approx(answer.probability, abs=1e-12)
