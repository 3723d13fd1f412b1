"""The vocabulary of space: answers of stock ProbLog on the program text, its laws, and an author's rules over it."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import POSE, feature, hypothesis, random_situations, situation
from stock_worlds import evaluated

from plogic.base.errors import InconsistentError
from plogic.facts.situation import names_of
from plogic.facts.spatial import BodyFact, Space
from plogic.logic.served.engine import Text
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.query import answers
from plogic.scene.asking.relevant import relevant
from plogic.scene.text.program_text import program_text

QUICK = settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
GOALS = (
    "left_of(X, Y)", "right_of(X, Y)", "nearer(X, Y)", "farther(X, Y)", "gap(X, Y, V)", "near(X, Y, 0.5)", "above(X, Y)", "below(X, Y)", "on(X, Y)",
    "in_view_of_camera(X)", "partly_in_view_of_camera(X)", "handy(X, Y)",
)  # fmt: skip
RULES = "handy(X, Y) :- near(X, Y, 0.8), in_view_of_camera(X), \\+ above(X, Y)."


pytestmark = pytest.mark.usefixtures("served_here")


def with_space(subject, seed):
    """Its bodies anywhere; a few above others, on them, or on two together; now and then one that nobody described."""
    rng = Random(seed)  # noqa: S311 - a test's
    ids = [h.id for h in subject.hypotheses]
    known = [name for name in ids if rng.random() < 0.8]
    views = ["inside", "cut", "outside"]
    middles = [tuple(rng.choice([-0.5, 0.0, 0.25, 0.5]) for _ in "xyz") for _ in known]
    bodies = tuple(
        BodyFact(name, at, rng.choice([0.5, 1.0, 2.0]), rng.choice(views))
        for name, at in zip(known, middles, strict=True)
    )
    pairs = [(x, y) for i, x in enumerate(known) for y in known[i + 1 :]]
    above = tuple(pair for pair in pairs if rng.random() < 0.6)
    both = tuple((x, y, z) for x, y in above for z in known if z not in (x, y) and rng.random() < 0.4)
    gaps = tuple((x, y, rng.choice([0.0, 0.3, 0.7])) for x, y in pairs)
    on = tuple(pair for pair in above if rng.random() < 0.5)
    return replace(subject, space=Space((0.0, -1.0, 0.0), "T_world_camera", bodies, gaps, above, on, both), rules=RULES)


def stock(subject, goal):
    """Goal, as users write it, → probability, where it is positive."""
    from plogic.logic.safety.mapping import shown

    results = evaluated(f"{program_text(subject)}\nquery({goal}).\n")
    names = names_of(subject)
    return {shown(term, names): p for term, p in results.items() if p > 0}


@QUICK
@given(random_situations(most=4), st.integers(0, 9999), st.sampled_from(GOALS))
def test_answers_equal_problog(subject, seed, goal):
    from problog.errors import InconsistentEvidenceError

    subject = with_space(subject, seed)
    try:
        theirs = stock(subject, goal)
    except InconsistentEvidenceError:
        with pytest.raises(InconsistentError):
            scene_answers(subject, [goal])
        return
    ours = {answer.goal: answer.probability for answer in scene_answers(subject, [goal])[0] if answer.probability > 0}
    assert ours == pytest.approx(theirs, abs=1e-9)


def holding(subject, *goals):
    """The answers of each goal, as sets of tuples of names."""
    found = scene_answers(subject, list(goals))
    return [{tuple(a.goal[a.goal.index("(") + 1 : -1].split(", ")) for a in row if a.probability > 0} for row in found]


@settings(QUICK, max_examples=12)
@given(st.integers(0, 9999))
def test_the_laws_of_left_nearer_near_and_their_converses(seed):
    """left_of and nearer: irreflexive, asymmetric, transitive; near: symmetric, and monotone in D."""
    rng = Random(seed)  # noqa: S311 - a test's
    bare = situation([hypothesis(f"h{i}", [feature("x", match=f"a{i}")]) for i in range(4)], smoothing=0.01)
    subject = with_space(bare, rng.randrange(10**6))
    goals = ("left_of", "right_of", "nearer", "farther", "below", "above")
    left, right, nearer, farther, below, above = holding(subject, *(f"{name}(X, Y)" for name in goals))
    close, closer = ({(x, y) for x, y, _ in found} for found in holding(subject, "near(X, Y, 0.5)", "near(X, Y, 0.2)"))
    for order in (left, nearer):
        assert not {(y, x) for x, y in order} & order
        assert all(x != y for x, y in order)
        assert {(x, z) for x, y in order for w, z in order if y == w} <= order
    for some, converse in ((left, right), (nearer, farther), (above, below)):
        assert {(y, x) for x, y in some} == converse
    assert {(y, x) for x, y in close} == close
    assert closer <= close


def test_what_nobody_described_is_a_point_at_its_origin():
    pose = (POSE[0], (0.0, 1.0, 0.0, 3.0), (0.0, 0.0, 1.0, 9.0), POSE[3])
    two = situation(
        [hypothesis("h1", [feature("x")]), hypothesis("h2", [feature("y", match="b")], camera_from_object=pose)]
    )
    near, nearer, above = holding(two, "gap(h1, h2, V)", "nearer(X, Y)", "above(X, Y)")
    assert near == {("h1", "h2", "5.0")}
    assert nearer == {("h1", "h2")}
    assert above == set()


def test_on_two_together_needs_both():
    three = [hypothesis(f"h{i}", [feature("x", match=f"a{i}"), feature("y", "C")]) for i in range(3)]
    subject = situation(
        three,
        space=Space((0, -1, 0), "T_world_camera", above=(("h0", "h1"), ("h0", "h2")), on_both=(("h0", "h1", "h2"),)),
    )
    (all_three,) = (a.probability for a in answers(subject, "(present(h0), present(h1), present(h2))"))
    for goal in ("on(h0, h1)", "on(h0, h2)"):
        assert [a.probability for a in answers(subject, goal)] == pytest.approx([all_three])
        assert [a.probability for a in answers(relevant(subject, [goal]), goal)] == pytest.approx([all_three])
    live = LiveScene(subject)
    live.remove("h2")
    assert live.answers("on(X, Y)") == []


def test_rules_of_a_file_may_speak_of_space():
    subject = with_space(situation([hypothesis(f"h{i}", [feature("x", match=f"a{i}")]) for i in range(2)]), 3)
    rules = Text("close_by(X, Y) :- gap(X, Y, V), V < 10.\n", "rules.pl")
    found = scene_answers(replace(subject, own=rules), ["close_by(h0, h1)"])[0]
    assert [a.probability for a in found] == [1.0]
    assert math.isclose(sum(p for p in stock(subject, "gap(h0, h1, V)").values()), 1.0)
