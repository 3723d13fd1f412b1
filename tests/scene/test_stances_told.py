"""What things stand on, as it is told: in each world, in `explain`, and with its probabilities."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from enumeration import log_weights
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, plane, random_situations, situation, with_support

from plogic.base.errors import InconsistentError
from plogic.facts.stances import Stance, Support, words_of_standing
from plogic.scene.asking.explanations import explain
from plogic.scene.asking.live import LiveScene, scene_answers
from plogic.scene.asking.presence import contributions
from plogic.scene.asking.stood import stood
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


def worlds_of(subject):
    try:
        return ranked_worlds(subject, 3).worlds
    except InconsistentError:
        return ()


def asked(subject, goal, given=()):
    """Each answer of a goal and its probability."""
    return {a.goal: a.probability for a in scene_answers(subject, [goal], given)[0]}


def as_given(subject, world):
    """A world as evidence."""
    return [("" if h.id in world.present else "\\+ ") + f"present('{h.id}')" for h in subject.hypotheses]


@QUICK
@given(random_situations(most=4), SEEDS)
def test_a_world_tells_the_most_probable_plane_and_then_stances(subject, seed):
    subject = with_support(subject, seed)
    worlds = worlds_of(subject)
    assert None not in [world.told for world in worlds]
    for world in worlds:
        given_world = as_given(subject, world)
        chances = asked(subject, "support(S)", given_world)
        named = chances.get(f"support({world.told.state})", 1.0 - sum(chances.values()))
        assert named >= max(chances.values(), default=0.0) - 1e-9
        assert named >= 1.0 - sum(chances.values()) - 1e-9
        if world.told.state == "none":
            assert world.told.stances == {}
            continue
        assert set(world.told.stances) == set(world.present)
        if world.told.state != "other":
            given_state = [*given_world, f"support({world.told.state})"]
            for name, stance in world.told.stances.items():
                rows = {**asked(subject, f"stance({name}, S, R)", given_state)}
                there = {g: p for g, p in rows.items() if "free" not in g and on_there(g, world, subject)}
                free = asked(subject, f"free({name})", given_state).get(f"free({name})", 0.0)
                on, _, face = stance.rpartition("/")
                found = there.get(f"stance({name}, {on}, {face})", 0.0) if on else free
                assert found >= max([*there.values(), free]) - 1e-9


def on_there(goal, world, subject):
    on = goal.split(", ")[1]
    return on in world.present or all(h.id != on for h in subject.hypotheses)


@QUICK
@given(random_situations(most=4), SEEDS)
def test_what_is_told_of_each_plane_and_stance_is_what_queries_answer(subject, seed):
    subject = with_support(subject, seed)
    if worlds_of(subject):
        found, support = stood(subject), subject.support
        ids = {h.id for h in subject.hypotheses}
        planes = asked(subject, "support_plane(S)")
        assert found.planes == pytest.approx(
            {p.name: planes.get(f"support_plane({p.name})", 0.0) for p in support.planes}
        )
        free = asked(subject, "free(H)")
        assert found.free == pytest.approx({name: free.get(f"free({name})", 0.0) for name in ids}, abs=1e-9)
        there = [f", present({s.on})" if s.on in ids else "" for s in support.stances]
        goals = [f"stance({s.hypothesis}, {s.on}, {s.face}){p}" for s, p in zip(support.stances, there, strict=True)]
        answers = scene_answers(subject, goals)
        assert found.stances == pytest.approx([a.probability for (a,) in answers], abs=1e-9)


def test_where_only_the_text_can_say_it_the_same_is_told():
    """Rules that speak of what the graph has summed out."""
    subject = replace(stack(), rules="luck_of(H) :- hit(H, x), present(H).\nevidence(luck_of(h1)).\n")
    by_text, on_graph = stood(subject), stood(stack())
    assert set(by_text.free) == set(on_graph.free) == {"h1", "h2"}
    (wanted,) = scene_answers(stack(), ["stance(h2, h1, 0)"], ["present(h1)"])[0]
    assert by_text.stances[1] == pytest.approx(wanted.probability, abs=1e-9)
    assert ranked_worlds(subject, 1).worlds[0].told.state == "s1"


def stack(reading="posterior", **changes):
    """H1 stands on a plane, h2 on h1, but for what they may be besides."""
    features = [[feature("x", match=f"a_{name}"), feature("y", "C")] for name in ("h1", "h2")]
    bodies = [hypothesis(name, some) for name, some in zip(("h1", "h2"), features, strict=True)]
    stances = Stance("h1", "s1", 2, 0.9, 3.0), Stance("h2", "h1", 0, 0.6, 4.0), Stance("h2", "s2", 1, 0.3, 3.5)
    planes = plane("s1", 0.5), plane("s2", 0.3)
    return situation(bodies, reading, support=Support(0.9, 0.1, planes, stances), **changes)


def test_evidence_on_planes_and_stances_changes_what_worlds_tell():
    for reading in ("score", "posterior"):
        live = LiveScene(stack(reading))
        live.observe("present(h1), present(h2)")
        assert live.worlds(1).worlds[0].told.state == "s1"
        live.observe("support_plane(s2)")
        told = live.worlds(1).worlds[0].told
        assert (told.state, told.stances["h1"]) == ("s2", "free")
        live.unobserve("support_plane(s2)")
        live.observe("free(h2)")
        told = live.worlds(1).worlds[0].told
        assert told.stances == {"h1": "s1/2", "h2": "free"}


def test_a_world_in_words():
    assert words_of_standing("s1", {"h1": "s1/2", "h2": "s1/0", "h3": "h1/0", "h4": "free"}) == (
        "s1: h1, h2; h1: h3; free: h4"
    )
    assert words_of_standing("none", {}) == "none"
    assert words_of_standing(None, {}) == ""


@QUICK
@given(random_situations(most=4, readings=("posterior",)), SEEDS)
def test_contributions_sum_to_the_bayes_factor(subject, seed):
    subject = with_support(subject, seed)
    ids, groups = [h.id for h in subject.hypotheses], [h.group for h in subject.hypotheses]
    logs = log_weights(replace(subject, overlaps=frozenset(), priors={}))
    rest = sum(1 << ids.index(name) for name in ids[1:])
    if len(set(groups)) == len(groups) and np.isfinite(logs[[rest, rest + 1]]).all():
        found = contributions(subject, "h1", ids[1:])
        assert sum(c.llr for c in found) == pytest.approx(logs[rest + 1] - logs[rest], abs=1e-9)


def line(subject, name, words):
    """The one line of an explanation that has these words."""
    (found,) = [line for line in explain(subject, f"present({name})").summary if words in line]
    return found


def test_explain_says_because_of_what_it_is_believed():
    subject = stack()
    found = line(subject, "h1", "stands on")
    weights = (
        0.5 * (0.1 + 0.9 * math.exp(3.0)) * (0.1 + 0.6 * math.exp(4.0)),
        0.1,
        0.3 * 0.1 * (0.1 + 0.6 * math.exp(4.0) + 0.3 * math.exp(3.5)),
        0.1 * 0.1 * (0.1 + 0.6 * math.exp(4.0)),
    )
    without = 0.5 * 0.1 + 0.1 + 0.3 * (0.1 + 0.3 * math.exp(3.5)) + 0.1 * 0.1
    gain = math.log(sum(weights) / without)
    assert found == f"  believed because it stands on s1, a plane of its own: {gain:+.3g} in log-odds"
    assert line(subject, "h2", "stands on").startswith("  believed because it stands on h1: +")
    assert "prior" in line(subject, "h1", ", and where it stands, changes its log-odds")


def test_explain_names_who_stands_there_too():
    stances = tuple(Stance(name, "s1", 0, 0.9, 2.0) for name in ("h1", "h2"))
    subject = replace(stack(), support=Support(0.9, 0.1, (plane("s1", 0.9),), stances))
    assert line(subject, "h1", "stands on").startswith("  believed because it stands on s1, the plane of h2: +")


def test_explain_says_what_is_against_it():
    lone = replace(stack(), support=Support(0.9, 0.0, (plane("s1", 1.0),), ()))
    found = line(lone, "h1", "stands on nothing known")
    assert found.startswith("  against: it stands on nothing known")
    assert found.endswith(f"{math.log(0.1):+.3g} in log-odds")


def test_explain_says_that_it_may_stand_so_by_chance():
    stances = (Stance("h1", "s1", 2, 0.9, 3.0),)
    for e in (0.12, 1.0):
        support = Support(0.9, 0.0, (plane("s1", 1.0),), stances, (("h1", e),))
        f = 0.1 + 0.9 * math.exp(3.0)
        gain = math.log(f / (1.0 - e + e * f))
        mark = "believed because" if e < 1.0 else "no evidence:"
        assert line(replace(stack(), support=support), "h1", "stands on s1") == (
            f"  {mark} it stands on s1, a plane of its own: {gain:+.3g} in log-odds, its pose standing so by chance"
            f" with {e:.3g} if it is not there"
        )


def test_explain_says_that_it_is_level_above_the_plane():
    support = Support(0.9, 0.0, (plane("s1", 1.0),), (), (("h1", 0.12),), (("h1", "s1", 4.0),))
    f = 0.1 * math.exp(4.0)
    gain = math.log(f / (1.0 - 0.12 + 0.12 * f))
    found = line(replace(stack(), support=support), "h1", "level above")
    assert found.startswith(
        f"  believed because it is level above s1, on something unknown, or stands on nothing: {gain:+.3g} in log-odds"
    )


def test_in_the_score_reading_it_is_told_as_no_evidence():
    found = line(stack("score"), "h2", "no evidence in this reading")
    assert found.startswith("  most probably it stands on h1; ")
    assert not [row for row in explain(replace(stack(), support=None), "present(h1)").summary if "stands" in row]


def test_explanations_choice_by_choice_name_the_choice():
    account = explain(stack(), "stands_on(h1, s1)")
    choices = {choice for e in account.why for choice in e.choices}
    assert {"support(s1)", "footing(h1, s1, 2)"} <= choices
