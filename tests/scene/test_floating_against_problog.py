"""Support as a soft constraint of Σc.

The factor graph is stock ProbLog's on the program text, and every world's weight by hand; its laws.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from enumeration import log_weights
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation, with_gravity
from stock_worlds import evaluated

from plogic.base.errors import InconsistentError, SituationError
from plogic.facts.situation import names_of
from plogic.facts.spatial import Foot, Gravity
from plogic.inference.marginals import beliefs
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.query import answers
from plogic.scene.asking.relevant import relevant
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=list(HealthCheck),
)
SEEDS = st.integers(0, 9999)


pytestmark = pytest.mark.usefixtures("served_here")


def stock(subject, goals):
    from plogic.logic.safety.mapping import shown

    text = "".join([program_text(subject), *(f"query({goal}).\n" for goal in goals)])
    found = evaluated(text)
    return {shown(term, names_of(subject)): p for term, p in found.items() if p > 0}


def worlds_of(subject):
    """Each world and its probability; {} where none is possible."""
    try:
        return {w.present: w.probability for w in ranked_worlds(subject, 10**6).worlds}
    except InconsistentError:
        return {}


def by_hand(subject):
    """The same from the definition."""
    logs, ids = log_weights(subject), [h.id for h in subject.hypotheses]
    weights = np.exp(logs)
    total = weights.sum()
    rows = {
        tuple(h for bit, h in enumerate(ids) if i >> bit & 1): float(w / total) for i, w in enumerate(weights) if w > 0
    }
    return rows if total > 0 else {}


@QUICK
@given(
    random_situations(most=4),
    SEEDS,
    st.sampled_from(["present(X)", "floats(X)", "held(X)", "rests_on(X, Y)", "rests_on(X, ground)"]),
)
def test_answers_equal_problog(subject, seed, goal):
    from problog.errors import InconsistentEvidenceError

    subject = with_gravity(subject, seed)
    try:
        theirs = stock(subject, [goal])
    except InconsistentEvidenceError:
        with pytest.raises(InconsistentError):
            scene_answers(subject, [goal])
        return
    ours = {answer.goal: answer.probability for answer in scene_answers(subject, [goal])[0] if answer.probability > 0}
    assert ours == pytest.approx(theirs, abs=1e-9)


@settings(QUICK, max_examples=120)
@given(random_situations(most=6), SEEDS)
def test_worlds_are_those_of_the_definition(subject, seed):
    subject = with_gravity(subject, seed)
    assert worlds_of(subject) == pytest.approx(by_hand(subject), abs=1e-9)


@QUICK
@given(random_situations(most=5), SEEDS)
def test_a_sure_unknown_support_changes_nothing(subject, seed):
    assert worlds_of(with_gravity(subject, seed, unknown_support=1.0)) == worlds_of(subject)


def floaters(subject, world):
    return [h for h in world if subject.gravity.floating(h, world)]


@QUICK
@given(random_situations(most=5), SEEDS, st.sampled_from([(0.5, 0.1), (0.9, 0.3), (0.1, 0.001)]))
def test_less_unknown_support_makes_floating_less_probable_by_its_ratio_for_each_that_floats(subject, seed, qs):
    """Against any world in which nothing floats."""
    high, low = (with_gravity(subject, seed, unknown_support=q) for q in qs)
    before, after = worlds_of(high), worlds_of(low)
    assert before.keys() == after.keys()
    shift = {world: after[world] / before[world] for world in before if before[world] > 1e-12}
    grounded = [shift[world] for world in shift if not floaters(high, world)]
    for world, ratio in shift.items():
        if grounded:
            assert ratio == pytest.approx(grounded[0] * (qs[1] / qs[0]) ** len(floaters(high, world)), rel=1e-6)


@QUICK
@given(random_situations(most=5), SEEDS)
def test_where_nothing_floats_in_any_world_nothing_changes(subject, seed):
    drawn = with_gravity(subject, seed, ground=0.02).gravity
    held = replace(subject, gravity=replace(drawn, rests=tuple((foot.id, "ground") for foot in drawn.feet)))
    assert worlds_of(held) == worlds_of(subject)


def lone(*names, **changes):
    """Hypotheses that have nothing to do with each other, of P(ev) ½ each, or of the prior."""
    return situation(
        [hypothesis(name, [feature("x", match=f"a_{name}"), feature("y", "C")]) for name in names], **changes
    )


def test_what_is_held_in_every_world_keeps_its_probability_beside_what_floats():
    """H3 hovers over h1, h2 stands on the ground.

    By hand h3's odds fall tenfold where the ground is told, and nobody else's change.
    """
    rests = (("h1", "ground"), ("h2", "ground"))
    subject = lone(
        "h1", "h2", "h3", gravity=Gravity(0.1, 0.0, (Foot("h1", 0, 0), Foot("h2", 0, 0), Foot("h3", 0.2, 0.2)), rests)
    )
    chances = ranked_worlds(subject).marginals
    assert chances == pytest.approx({"h1": 0.5, "h2": 0.5, "h3": 0.1 / 1.1})


def test_where_the_ground_is_not_told_it_is_where_the_lowest_of_the_world_stands():
    """Of two the higher floats only beside the lower: weights 1, 1, 1 and 0.1, so each is present with 1.1 in 3.1."""
    subject = lone("h1", "h2", gravity=Gravity(0.1, None, (Foot("h1", 0.0, 0.01), Foot("h2", 0.2, 0.21))))
    assert worlds_of(subject) == pytest.approx(
        {(): 1 / 3.1, ("h1",): 1 / 3.1, ("h2",): 1 / 3.1, ("h1", "h2"): 0.1 / 3.1}
    )
    (floats, held) = scene_answers(subject, ["floats(h2)", "rests_on(X, ground)"])
    assert floats[0].probability == pytest.approx(0.1 / 3.1)
    assert {a.goal: a.probability for a in held} == pytest.approx(
        {"rests_on(h1, ground)": 1.1 / 3.1, "rests_on(h2, ground)": 1 / 3.1}
    )
    near = replace(subject.gravity, feet=(Foot("h1", 0.0, 0.01), Foot("h2", 0.01, 0.02)))
    assert worlds_of(replace(subject, gravity=near)) == worlds_of(replace(subject, gravity=None))


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_stack_floats_without_its_lower_part(reading):
    feet = (Foot("h1", 0, 0), Foot("h2", 0.1, 0.1), Foot("h3", 0.2, 0.2))
    gravity = Gravity(0.1, 0.0, feet, (("h1", "ground"), ("h2", "h1"), ("h3", "h2")))
    subject = lone("h1", "h2", "h3", reading=reading, gravity=gravity)
    assert {world: floaters(subject, world) for world in worlds_of(subject) if floaters(subject, world)} == {
        ("h2",): ["h2"], ("h3",): ["h3"], ("h2", "h3"): ["h2"], ("h1", "h3"): ["h3"],
    }  # fmt: skip
    assert worlds_of(subject) == pytest.approx(by_hand(subject))
    floating = sum(p for world, p in worlds_of(subject).items() if "h3" in floaters(subject, world))
    assert answers(subject, "floats(h3)")[0].probability == pytest.approx(floating)


def test_nobody_floats_where_nobody_said_that_gravity_holds():
    subject = lone("h1", "h2")
    assert "excused" not in program_text(subject)
    for goal in ("floats(X)", "held(X)", "rests_on(X, Y)"):
        assert scene_answers(subject, [goal]) == [[]]
        assert stock(subject, [goal]) == {}


def test_a_removed_holder_leaves_what_it_held_to_float():
    gravity = Gravity(0.1, 0.0, (Foot("h1", 0, 0), Foot("h2", 0.1, 0.1)), (("h1", "ground"), ("h2", "h1")))
    live = LiveScene(lone("h1", "h2", gravity=gravity))
    live.remove("h1")
    assert live.marginals()["h2"] == pytest.approx((0.1 / 1.1,) * 2)
    assert live.answers("floats(h2)")[0].probability == pytest.approx(0.1 / 1.1)


@QUICK
@given(random_situations(most=5), SEEDS)
def test_the_relevant_part_gives_the_same_answer(subject, seed):
    subject = with_gravity(subject, seed)
    if worlds_of(subject):
        goals = "present(h1)", "floats(h1)", "rests_on(h1, ground)", "rests_on(h1, X)"
        for goal, whole in zip(goals, scene_answers(subject, goals), strict=True):
            part = scene_answers(relevant(subject, [goal]), [goal])[0]
            assert [a.probability for a in part] == pytest.approx([a.probability for a in whole])


def test_forty_at_different_heights_are_exact_at_once():
    """A chain, no table over all: by dynamic programming over the heights, from the lowest up."""
    names = [f"h{i}" for i in range(40)]
    subject = lone(
        *names, gravity=Gravity(0.1, None, tuple(Foot(name, 0.1 * i, 0.1 * i) for i, name in enumerate(names)))
    )
    empty, some = 1.0, 0.0
    for _ in names:
        some += 0.1 * some + empty
    solved = beliefs(scene_graph(subject).graph)
    assert solved.log_z[0] == pytest.approx(math.log((empty + some) / 2**40))
    ranking = ranked_worlds(subject, 5)
    assert [len(w.present) for w in ranking.worlds] == [0, 1, 1, 1, 1]
    assert ranking.worlds[0].probability == pytest.approx(1 / (empty + some))


@pytest.mark.parametrize(
    ("gravity", "message"),
    [
        (Gravity(0.0), "unknown_support: 0.0 is not above 0"),
        (Gravity(1.5), "unknown_support: 1.5 is not a number from 0.0 to 1.0"),
        (Gravity(0.1, feet=(Foot("h9", 0, 0),)), "foot: 'h9' is unknown"),
        (Gravity(0.1, feet=(Foot("h1", 1, 0),)), "foot of h1: low"),
        (Gravity(0.1, feet=(Foot("h1", 0, 0), Foot("h1", 0, 0))), "occurs twice"),
        (Gravity(0.1, rests=(("h1", "ground"),)), "rests_on: 'ground' is unknown"),
        (Gravity(0.1, rests=(("h1", "h1"),)), "'h1' rests on itself"),
        (Gravity(0.1, math.nan), "ground: nan"),
    ],
)
def test_what_contradicts_itself_is_refused(gravity, message):
    with pytest.raises(SituationError, match=message):
        ranked_worlds(lone("h1", "h2", gravity=gravity))


def test_no_hypothesis_is_called_the_ground():
    with pytest.raises(SituationError, match="so the ground is called"):
        ranked_worlds(lone("ground", gravity=Gravity(0.1)))
