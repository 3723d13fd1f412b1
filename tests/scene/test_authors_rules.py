"""Author's rules that observe and constrain (§9.7): beside a question, in a live scene, by the text, and blame."""

from __future__ import annotations

import pytest
from situations import feature, hypothesis, situation, towers
from stock_worlds import assert_same_worlds

from plogic.base.errors import InconsistentError, NegativeCycleError, OutsideError, ProgramError
from plogic.facts.spatial import Space
from plogic.logic.served.engine import Text
from plogic.scene.asking.explanations import explain, present
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.query import answers, answers_until
from plogic.scene.asking.relevant import relevant
from plogic.scene.factors.asked_formulas import together
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.blame import blamed_without_scene
from plogic.scene.worlds.ranked_worlds import ranked_worlds

RULES = """0.1::wet.
slips(X) :- object(X, _), wet.
constraint(two) :- present(a), present(b).
0.25::constraint_may_fail(two).
constraint(dry(X)) :- slips(X), detected(X, F), feature(X, F, corner).
0.5::constraint_may_fail(dry(_)).
"""
GOALS = ("present(H)", "wet", "constraint(N)", "slips(X)", "present(a), wet")


pytestmark = pytest.mark.usefixtures("served_here")


def pair(reading="score", mode="to_B", **changes):
    """Two that know nothing of each other, each of some probability."""
    members = [
        hypothesis(name, [feature(f"{name}{i}", case, dv=0.3) for i, case in enumerate("AAC")]) for name in ("a", "b")
    ]
    return situation(members, reading, mode, **changes)


def told(found):
    return {answer.goal: answer.probability for answer in found}


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_beside_a_question_they_say_what_they_say_in_the_knowledge_base(reading):
    ours, beside = pair(reading, rules=RULES), pair(reading, own=Text(RULES, "mine.pl"))
    half = len(RULES) // 2 + RULES[len(RULES) // 2 :].index("\n") + 1
    split = pair(reading, rules=RULES[:half], own=Text(RULES[half:], "mine.pl"))
    for goal in GOALS:
        assert told(answers(beside, goal)) == pytest.approx(told(answers(ours, goal)), abs=1e-12)
        assert told(answers(split, goal)) == pytest.approx(told(answers(ours, goal)), abs=1e-12)
    assert ranked_worlds(split).marginals == pytest.approx(ranked_worlds(ours).marginals, abs=1e-12)
    assert ranked_worlds(beside).log_evidence == pytest.approx(ranked_worlds(ours).log_evidence, abs=1e-12)


def test_a_softened_constraint_weighs_what_it_may_fail():
    plain = ranked_worlds(pair())
    soft = ranked_worlds(pair(rules="constraint(two) :- present(a), present(b).\n0.25::constraint_may_fail(two)."))
    (both,) = (w.probability for w in plain.worlds if w.present == ("a", "b"))
    (less,) = (w.probability for w in soft.worlds if w.present == ("a", "b"))
    assert less == pytest.approx(both / 4 / (1 - 0.75 * both), rel=1e-12)
    assert together(pair(rules=RULES), [("a", "b")])[0] < together(pair(), [("a", "b")])[0]


def test_a_live_scene_observes_beside_them():
    subject = pair("posterior", rules=RULES)
    live = LiveScene(subject)
    before = live.marginals()["a"][0]
    live.observe("wet")
    live.observe("\\+ present(b)")
    for goal in GOALS:
        assert told(live.answers(goal)) == pytest.approx(told(answers(subject, goal, given=live.given)), abs=1e-9)
    assert live.worlds(1).marginals["b"] == 0.0
    live.unobserve()
    assert live.marginals()["a"][0] == before


def test_by_a_deadline_too():
    found, exact = answers_until(pair(rules=RULES), "constraint(N)", seconds=30)
    assert exact
    assert told(found) == pytest.approx(told(answers(pair(rules=RULES), "constraint(N)")))
    assert ranked_worlds(pair(rules=RULES), seconds=30).exact


@pytest.mark.parametrize(("reading", "choice"), [("score", "pick(a, F)"), ("posterior", "hit(a, F)")])
def test_what_the_graph_has_summed_out_is_for_the_program_text(reading, choice):
    subject = pair(reading, rules=f"constraint(k) :- {choice}, present(b).\n0.5::constraint_may_fail(k).")
    with pytest.raises(OutsideError):
        scene_graph(subject)
    ranking = assert_same_worlds(subject)
    (both,) = together(subject, [("a", "b")])
    assert both[0] == pytest.approx(sum(w.probability for w in ranking.worlds if w.present == ("a", "b")), abs=1e-9)
    assert told(answers(subject)) == pytest.approx({f"present({h})": p for h, p in ranking.marginals.items()}, abs=1e-9)
    assert present(subject, "present(a)") is None
    assert explain(subject, "present(a)").probability == pytest.approx(ranking.marginals["a"], abs=1e-9)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_the_evidence_of_the_text_is_that_of_the_graph(reading):
    rules = "constraint(k) :- present(a), present(b).\n0.5::constraint_may_fail(k).\n"
    by_graph = ranked_worlds(pair(reading, rules=rules))
    by_text = ranked_worlds(pair(reading, rules=rules + "constraint(never) :- possible(fail).\n"))
    assert by_text.log_evidence == pytest.approx(by_graph.log_evidence, abs=1e-9)
    assert {w.present: w.causes for w in by_text.worlds} == {w.present: w.causes for w in by_graph.worlds}


def test_choices_of_two_grounders_are_not_mixed():
    subject = pair(rules="0.3::wet.\nodd :- between(1, 2, N), N > 1, wet, present(a).\n")
    live = LiveScene(subject)
    live.observe("wet")
    with pytest.raises(OutsideError):
        live.answers("odd")
    assert told(answers(subject, "odd", given=["wet"])) == pytest.approx(
        told(scene_answers(subject, ["odd"], ["wet"])[0]), abs=1e-9
    )


def test_what_they_couple_is_one_part():
    assert len(relevant(pair(), ["present(a)"]).hypotheses) == 1
    assert len(relevant(pair(rules=RULES), ["present(a)"]).hypotheses) == 2


def test_which_of_them_leave_no_world_is_told():
    rules = "0.1::wet.\nevidence(wet).\nconstraint(dry) :- wet.\nconstraint(a) :- present(a).\n"
    with pytest.raises(InconsistentError) as caught:
        ranked_worlds(pair(rules=rules))
    assert str(caught.value) == "no world satisfies rules.pl:2:1: evidence(wet) and rules.pl:3:1: constraint(dry)"
    mine = Text("constraint(b) :- present(b).\nevidence(present(b)).", "mine.pl")
    with pytest.raises(InconsistentError, match=r"mine\.pl:1:1: constraint\(b\) and mine\.pl:2:1: evidence"):
        answers(pair(own=mine))
    text = rules + "constraint(never) :- possible(fail).\n"
    with pytest.raises(InconsistentError, match=r"rules\.pl:2:1: evidence\(wet\) and rules\.pl:3:1: constraint\(dry\)"):
        answers(pair(rules=text))


def test_evidence_of_a_question_is_not_blamed_on_the_author():
    with pytest.raises(InconsistentError, match="no world satisfies the evidence"):
        answers(pair(rules=RULES), given=["present(a), \\+ present(a)"])


@pytest.mark.parametrize(("rules", "blamed"), [
    ("0.1::wet.\nevidence(wet).", None),
    ("constraint(x(X)) :- present(X).\n0.2::constraint_may_fail(x(_)).\nevidence(\\+ y).\n0.1::y.", None),
    ("constraint(x) :- present(_).\nevidence(y).\ny :- object(_, t).", None),
    ("dry.\nevidence(\\+ dry).", "rules.pl:2:1: evidence(\\+ dry)"),
    ("0.1::w.\nconstraint(a) :- w.\nevidence(w).\nconstraint(b) :- present(_).", "rules.pl:2:1: constraint(a) and rules.pl:3:1: evidence(w)"),
    ("0.1::w.\nconstraint(a) :- w.\n0.1::constraint_may_fail(a).\nevidence(w).", None),
])  # fmt: skip
def test_what_leaves_no_world_whatever_is_seen(rules, blamed):
    assert blamed_without_scene(rules) == (None if blamed is None else f"no world satisfies {blamed}")


def test_a_cycle_of_the_scene_is_told_where_it_was_written():
    space = Space((0.0, -1.0, 0.0), "T_world_camera", (), (("a", "b", 0.1),), (), (), ())
    subject = pair(space=space, rules="\nwins(X) :- near(X, Y, 0.5), \\+ wins(Y).\nconstraint(w) :- wins(_).")
    with pytest.raises(NegativeCycleError, match=r"rules\.pl:2:"):
        ranked_worlds(subject)


def test_explanations_show_choices_and_constraints():
    subject = pair(rules=RULES.replace("0.25::constraint_may_fail(two).\n", ""))
    account = explain(subject, "slips(a)")
    (first, *_) = account.why
    assert "wet" in first.choices
    assert first.probability < 0.1
    summary = present(subject, "present(a)").summary
    assert "  keeps constraint(two)" in summary
    assert any(line.startswith("  violates constraint(dry(a)), which may fail, with probability ") for line in summary)


def test_what_excludes_a_goal_is_told():
    rules = "0.1::wet.\nevidence(wet).\nconstraint(dry(X)) :- wet, object(X, box).\nconstraint(other) :- present(b).\n"
    account = explain(pair(rules=rules), "present(a)")
    assert account.probability == 0.0
    told = "no world holds it, because of rules.pl:2:1: evidence(wet) and rules.pl:3:1: constraint(dry(X))"
    assert account.notes[-1] == told
    assert "because of" not in str(explain(pair(rules=rules), "left_of(a, a)").notes)
    assert "because of" not in str(explain(pair(rules="0.1::wet."), "left_of(a, a)").notes)


def test_a_scene_without_observations_has_the_same_graph():
    plain, ruled = towers("posterior"), towers("posterior", rules="tall(H) :- present(H). 0.2::wet.")
    assert ranked_worlds(plain) == ranked_worlds(ruled)
    assert program_text(ruled).startswith(program_text(plain).split("% ==== (5)")[0].rstrip())


def test_a_probability_that_the_scene_makes_wrong_is_told_where_it_was_written():
    subject = pair(rules="\nP::odd(X) :- distance(X, D), P is D * 3, present(X).\nconstraint(odd) :- odd(_).")
    with pytest.raises(ProgramError, match=r"rules\.pl:2:\d+: 15\.0 is not a probability: it must be from 0 to 1"):
        ranked_worlds(subject)
