"""Explanations are minimal sets of choices that entail the goal (ICL, §8)."""

from __future__ import annotations

import pytest
from situations import towers

from plogic.logic.served.engine import Text
from plogic.scene.asking.explanations import explain

pytestmark = pytest.mark.usefixtures("programs_run_here")

WET = Text("0.3::rain. 0.5::sprinkler. wet :- rain. wet :- sprinkler, \\+ rain. 0.9::slip(X) :- wet, p(X). p(a). p(b).")


def goals(reason):
    yield reason.goal
    for child in reason.children:
        yield from goals(child)


def leaves(reason):
    return [reason] if not reason.children else [leaf for child in reason.children for leaf in leaves(child)]


def test_explanations_of_a_goal_and_of_its_negation():
    account = explain(WET, "wet")
    assert {frozenset(e.choices): e.probability for e in account.why} == pytest.approx(
        {frozenset({"rain"}): 0.3, frozenset({"sprinkler"}): 0.5}
    )
    assert account.covered.listed == pytest.approx((account.probability, account.probability)), (
        "together they are the goal, overlap and all"
    )
    assert account.covered.unlisted == 0
    assert [set(e.choices) for e in account.why_not] == [{"\\+ sprinkler", "\\+ rain"}]
    assert account.failure is None


def test_what_holds_in_every_world_by_one_of_two_rules_is_told_by_cases():
    tree = explain(WET, "wet").why[0].tree
    assert tree.kind == "cases"
    assert [way.goal for way in tree.children] == ["rain", "\\+ rain"]


def test_explanations_given_evidence():
    account = explain(WET, "wet", given=["\\+ rain"])
    best = account.why[0]
    assert set(best.choices) == {"sprinkler"}
    assert best.given_evidence == pytest.approx(0.5)
    assert len(account.why) == 1, "rain contradicts the evidence"
    assert account.probability == pytest.approx(0.5)


def test_recursion_ends():
    graph = Text(
        "0.3::e(1,2). 0.5::e(2,3). 0.2::e(1,3). 0.1::e(3,1). path(X,Y) :- e(X,Y). path(X,Y) :- e(X,Z), path(Z,Y)."
    )
    account = explain(graph, "path(1, 3)")
    assert [set(e.choices) for e in account.why] == [{"e(1, 3)"}, {"e(1, 2)", "e(2, 3)"}]


def test_an_object_is_explained_down_to_its_data():
    best = explain(towers(mode="drop"), "present(t2)").why[0]
    assert best.choices == ("ev_holds(t2, [t1])",), "ev_holds(t1, []) is certain, and no choice"
    assert "ev_holds(t1, [])" in list(goals(best.tree))
    assert "in_image(t2, 'apex/a0')" in [leaf.goal for leaf in leaves(best.tree)]
    assert {leaf.kind for leaf in leaves(best.tree)} <= {"fact", "choice", "absent", "check"}


def test_each_pick_is_an_explanation_in_mode_to_b():
    account = explain(towers(mode="to_B"), "present(t2)", most=3)
    assert account.why[0].choices == ("pick(t2, 'apex/a0')",)
    assert account.why[0].given_evidence == pytest.approx(0.0789, abs=0.01)
    assert all("/d" in choice for e in account.why_not for choice in e.choices), (
        "what speaks against it are the novel items"
    )


def test_why_not_names_the_condition_that_fails():
    account = explain(towers(mode="drop"), "case(t2, 'corner/c0', c)")
    assert account.probability == 0
    assert account.why == ()
    assert "\\+ hidden(t2, 'corner/c0')" in list(goals(account.failure))
    assert "behind_surface(t2, 'corner/c0', t1)" in list(goals(account.failure))


def test_why_not_of_something_unheard_of():
    account = explain(WET, "slip(c)")
    assert list(goals(account.failure)) == ["slip(c)", "p(c)"]


def test_findall_is_computed_from_its_choices():
    account = explain(Text("a :- findall(X, b(X), [1, 2]). 0.5::b(1). 0.4::b(2). 0.1::b(3)."), "a")
    assert [set(e.choices) for e in account.why] == [{"b(1)", "b(2)", "\\+ b(3)"}]
    assert account.why[0].tree.children[0].kind == "computed"
    assert {leaf.goal for leaf in leaves(account.why[0].tree)} == {"b(1)", "b(2)", "\\+ b(3)"}
    assert account.probability == pytest.approx(0.18)
