"""ev against Shanahan's value and the posterior on the same scenes, with the laws of §5.7, §3.8, §8, and the two dv."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest
from comparing import abducibles, beliefs_of, rows_of, situation_with, turned
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import (
    belief_at,
    camera_pose,
    cycle_of,
    data,
    one_before_the_other,
    perceiver,
    posed_at,
    scene,
    side_by_side,
    towers,
)

from plogic.cycle.delta import Options, delta_of
from plogic.cycle.state import considered
from plogic.match.gamma.data import data_of
from plogic.match.hand.hand_models import type_index
from plogic.match.judged.expectation import hidden_by, matched, pose_of
from plogic.measures.distinctiveness import distinctiveness, distinctiveness_over_delta, instance_counts
from plogic.measures.explanatory import explanatory_value, shanahan_values
from plogic.scene.worlds.ranked_worlds import ranked_worlds

TRUTHS = [("t1", 8000), ("t2", 8001), ("t1", 8002), ("t2", 8003)]
OTHER = {"t1": "t2", "t2": "t1"}


def one_tower(name, seed, **options):
    rng = np.random.default_rng(seed)
    return scene(rng, {name: camera_pose(rng, (3.5, 6.0))}, **options)


def rivals(name, pose):
    """Four rival explanations in one place: the right one, turned, of the other type, and moved."""
    return {
        "right": (name, pose),
        "turned": (name, turned(pose, 25.0)),
        "other type": (OTHER[name], pose),
        "moved": (name, turned(pose, 0.0, (0.15, 0.0, 0.0))),
    }


@pytest.fixture(scope="module")
def tables():
    """Per scene, a row for each rival with its three numbers."""
    shots = [(name, one_tower(name, seed)) for name, seed in TRUTHS]
    return [rows_of(rivals(name, shot.poses[name]), shot) for name, shot in shots]


def test_all_three_measures_put_the_right_hypothesis_first(tables):
    assert all(len(rows) > 1 for rows in tables)
    assert len(tables) > 0
    for rows in tables:
        for measure in ("ev", "shanahan", "posterior"):
            values = {row.name: getattr(row, measure) for row in rows}
            assert max(values, key=values.get) == "right", (measure, values)


def test_shanahans_values_sum_to_one_and_ev_does_not(tables):
    for rows in tables:
        assert sum(row.shanahan for row in rows) == pytest.approx(1.0)
        assert all(-1.0 <= row.ev <= 1.0 for row in rows)
        assert all(0.0 <= row.posterior <= 1.0 for row in rows)
        assert sum(row.posterior for row in rows) <= 1.0 + 1e-9, "A4 lets at most one of them be present"
    assert any(abs(sum((row.ev + 1) / 2 for row in rows) - 1.0) > 0.1 for rows in tables)


def test_on_wrong_hypotheses_the_measures_disagree(tables):
    """P(ev) of a wrong pose is far from 0, for what is hidden and missed supports it.

    The other two leave it nothing.
    """
    wrong = [row for rows in tables for row in rows if row.name == "turned"]
    assert wrong
    for row in wrong:
        assert (row.ev + 1) / 2 > 0.2
        assert row.shanahan < 1e-6
        assert row.posterior < 1e-6


# --- §5.7: adding a rival ---


def close_rivals(seed):
    """Hypotheses so near to each other that Γ hardly tells them.

    A few matches, noise, and shifts of a few millimetres.
    """
    rng = np.random.default_rng(seed)
    shot = scene(rng, {"t1": camera_pose(rng, (5.0, 6.0))}, hit=0.9, clutter=4)
    pose = shot.poses["t1"]
    shifts = {"one": 0.0, "two": 0.002, "three": -0.002}
    return shot, {label: ("t1", turned(pose, 0.0, (x, 0, 0))) for label, x in shifts.items()}


@pytest.mark.parametrize("seed", [8010, 8011, 8012])
def test_adding_a_rival_lowers_shanahans_and_the_posterior_and_leaves_ev_alone(seed):
    shot, poses = close_rivals(seed)
    before = {row.name: row for row in rows_of({k: poses[k] for k in ("one", "two")}, shot)}
    after = {row.name: row for row in rows_of(poses, shot)}
    for name in ("one", "two"):
        assert after[name].ev == before[name].ev
        assert after[name].shanahan < before[name].shanahan
        assert after[name].posterior < before[name].posterior


@pytest.mark.parametrize("seed", [8010, 8011, 8012])
def test_close_rivals_share_one_presence(seed):
    """However many copies enter by hand, the type is as surely there: they are one instance's alternative (§8)."""
    shot, poses = close_rivals(seed)
    alone = sum(row.posterior for row in rows_of({"one": poses["one"]}, shot))
    together = sum(row.posterior for row in rows_of(poses, shot))
    assert together == pytest.approx(alone, abs=1e-6)


# --- §5.7: duplicating every feature k-fold ---


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize(("name", "seed"), TRUTHS[:2])
def test_duplicating_every_feature_leaves_ev_alone(name, seed, times):
    """A type each of whose features is there k times, in a Γ each of whose appearances is.

    The same ev from the posed cloud.
    """
    shot = one_tower(name, seed)
    pose, of, kind = shot.poses[name], data(shot), towers().type(name)
    many = replace(kind, features=kind.features * times, all_features=kind.all_features * times)
    copies = [replace(a, id=f"{a.id}_{k}") for k in range(times) for a in shot.gamma.appearances]
    more = data_of(copies, shot.gamma.camera)
    index = type_index(many, perceiver().dv)
    posed = matched(pose_of(many, pose, more, towers()), more, index.allowed(more), towers().rates.match_tolerance)
    once, dv = posed_at(name, pose, of), perceiver().dv
    assert posed.detected.sum() == times * once.detected.sum()
    assert explanatory_value(posed.support(), dv) == pytest.approx(explanatory_value(once.support(), dv), abs=1e-12)
    assert distinctiveness(instance_counts([many])) == pytest.approx(distinctiveness(instance_counts([kind])))


@pytest.mark.parametrize("times", [2, 5])
@pytest.mark.parametrize("seed", [8010, 8013])
def test_duplicating_every_feature_multiplies_shanahans_log_odds(seed, times):
    """The posterior's ratio multiplies too: it counts every feature as evidence of its own, which ev does not."""
    shot, poses = close_rivals(seed)
    poses |= {"far": ("t1", turned(poses["one"][1], 0.0, (0.03, 0.0, 0.0)))}
    of = data(shot)
    beliefs = beliefs_of(poses, of)
    priors = {label: abducibles(b, of) for label, b in beliefs.items()}
    once, more = shanahan_values(priors), shanahan_values({label: p * times for label, p in priors.items()})
    assert once["one"] != once["far"]
    for label in ("two", "far"):
        assert log(more["one"] / more[label]) == pytest.approx(
            times * log(once["one"] / once[label]), rel=1e-9, abs=1e-9
        )


# --- §3.8: what each occlusion relation predicts ---


def evs(shot):
    """The ev of both true hypotheses alone, and beside the other."""
    of, dv = data(shot), perceiver().dv
    beliefs = {name: belief_at(name, pose, of) for name, pose in shot.poses.items()}
    alone, beside = {}, {}
    for name, other in (("t1", "t2"), ("t2", "t1")):
        posed = beliefs[name]
        alone[name] = explanatory_value(posed.support(), dv)
        beside[name] = explanatory_value(posed.support(hidden_by(posed, beliefs[other])), dv)
    return alone, beside, beliefs


@pytest.mark.parametrize("seed", range(8020, 8026))
def test_non_occlusion_changes_neither_ev(seed):
    rng = np.random.default_rng(seed)
    alone, beside, _ = evs(scene(rng, side_by_side(rng)))
    assert alone == beside


@pytest.mark.parametrize("seed", range(8030, 8036))
def test_partial_occlusion_leaves_the_one_in_front_and_raises_what_is_behind(seed):
    rng = np.random.default_rng(seed)
    alone, beside, beliefs = evs(scene(rng, one_before_the_other(rng), clutter=0))
    front, back = beliefs["t1"], beliefs["t2"]
    hidden = hidden_by(back, front)
    assert not (back.candidate & back.detected & hidden).any(), "it hides no detected feature: the law's condition"
    assert (back.candidate & ~back.detected & hidden).any()
    assert beside["t1"] == alone["t1"]
    assert beside["t2"] > alone["t2"]


@pytest.mark.parametrize("seed", range(8030, 8034))
def test_partial_occlusion_raises_the_posteriors_log_odds_by_exactly_the_waived_misses(seed):
    """Explaining away (§8), on a posed scene: log-odds are taken as ratios of evidence, which never saturate."""
    rng = np.random.default_rng(seed)
    shot = scene(rng, one_before_the_other(rng), clutter=0)
    of = data(shot)
    back, front = (belief_at(name, shot.poses[name], of) for name in ("t2", "t1"))
    alone, beside = (situation_with(beliefs, of, shot) for beliefs in ([back], [back, front]))
    assert not beside.rivals
    waived = [
        f for f in beside.hypotheses[0].features if beside.hypotheses[0].expects(f) and f.hidden_by and f.match is None
    ]
    assert waived
    assert ratio_of_t2(beside) - ratio_of_t2(alone) == pytest.approx(
        -sum(log(1 - f.hit_rate) for f in waived), abs=1e-6
    )


def ratio_of_t2(situation):
    """The logarithm of P(Γ | t2 is there) / P(Γ | it is not); t1, where it is a hypothesis, stands for certain."""
    there, not_there = (ranked_worlds(replace(situation, priors={"t1": 1.0, "t2": p})).log_evidence for p in (1.0, 0.0))
    return there - not_there


def test_total_occlusion_leaves_no_evidence_either_way():
    """Everything hidden: no miss counts, and the ratio of presence is 0."""
    shot = one_tower("t1", 8040)
    posed = posed_at("t1", shot.poses["t1"], data_of([], shot.gamma.camera))
    support = posed.support(np.ones(len(posed.uv), dtype=bool))
    assert sum(c.B for c in support.values()) > 0
    assert all(c.A == c.C == c.D == 0 for c in support.values())


CASES = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=58, max_size=58)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(CASES)
def test_an_occluder_that_hides_no_detected_feature_never_lowers_ev(cases):
    """The law of §3.8 for every pattern of expected, detected and hidden; and one that hides some may lower it."""
    kind = towers().type("t1")
    empty = data_of([], scene(np.random.default_rng(0), {}, clutter=0).gamma.camera)
    posed = pose_of(kind, camera_pose(np.random.default_rng(8041)), empty, towers())
    expected, detected, hidden = (np.array(column) for column in zip(*cases, strict=True))
    everywhere = np.ones(58, dtype=bool)
    nowhere = ~everywhere
    posed = replace(
        posed, in_image=everywhere, in_lobe=expected, self_hidden=nowhere, matches=np.where(detected, np.arange(58), -1)
    )
    dv = perceiver().dv
    assert explanatory_value(posed.support(hidden & ~(expected & detected)), dv) >= explanatory_value(
        posed.support(), dv
    )
    assert (
        explanatory_value(posed.support(hidden & ~detected), dv) >= explanatory_value(posed.support(hidden), dv) - 1e-12
    )


# --- §8: duplicates ---


@pytest.mark.parametrize("reading", ["score", "posterior"])
@pytest.mark.parametrize("stand", [side_by_side, one_before_the_other])
def test_duplicates_of_a_hypothesis_change_no_types_presence(reading, stand):
    """Near-duplicates are merged before the program is written: what enters it is the same Δh."""
    rng = np.random.default_rng(8050)
    shot = scene(rng, stand(rng))
    of, cycle = data(shot), cycle_of(shot.gamma)
    rivals = [
        posed_at(b.type, nudged(b), of).told(worth=b.worth, surplus=b.surplus, ev=b.ev, status="rival")
        for b in cycle.accepted
        for _ in range(3)
    ]
    twice = replace(cycle, considered=tuple(considered(rivals, cycle.accepted)))
    before, after = (presence(c, of, reading) for c in (cycle, twice))
    assert before.keys() == {"t1", "t2"}
    assert after == pytest.approx(before, abs=1e-12)


def nudged(posed):
    return turned(posed.camera_from_object, 0.5, (0.003, 0.0, 0.0))


def presence(cycle, of, reading):
    """P(some object of the type is there), for every type of Δh."""
    situation = delta_of(cycle, of, towers(), perceiver().dv, Options(reading=reading)).situation
    kind = {h.id: h.type for h in situation.hypotheses}
    worlds = ranked_worlds(situation, 1000).worlds
    return {t: sum(w.probability for w in worlds if any(kind[h] == t for h in w.present)) for t in set(kind.values())}


# --- dv over Σo against dv over Δ (§5.1, the variant of §9) ---


def test_over_an_empty_delta_dv_falls_back_to_the_background():
    kinds = towers().types
    assert distinctiveness_over_delta([], kinds) == distinctiveness(instance_counts(kinds)) == perceiver().dv


@pytest.mark.parametrize("seed", [8060, 8061])
def test_with_both_towers_present_dv_is_that_of_the_background(seed):
    """Δ holds one instance of each type of Σo: the same composition."""
    rng = np.random.default_rng(seed)
    cycle = cycle_of(scene(rng, side_by_side(rng)).gamma)
    present = [b.object_type for b in cycle.accepted]
    assert sorted(t.name for t in present) == ["t1", "t2"]
    assert distinctiveness_over_delta(present, towers().types) == perceiver().dv


@pytest.mark.parametrize(
    ("name", "dv"),
    [
        ("t1", {"apex": 1.0, "corner": 1 - 8 / 58, "patch": 1 - 50 / 58}),
        ("t2", {"apex": 1 - 1 / 54, "corner": 1 - 8 / 54, "patch": 1 - 45 / 54}),
    ],
)
def test_with_one_tower_present_dv_differs_as_by_hand(name, dv):
    shot = one_tower(name, 8062)
    present = [b.object_type for b in cycle_of(shot.gamma).accepted]
    assert [t.name for t in present] == [name]
    over_delta = distinctiveness_over_delta(present, towers().types)
    assert over_delta == pytest.approx(dv)
    assert over_delta != perceiver().dv
    assert sum(1 - v for v in over_delta.values()) == pytest.approx(1.0), "ΣF P(dv(F)) = 1 (§5.1)"


def test_two_of_one_type_are_as_distinctive_as_one():
    kind = towers().type("t1")
    assert distinctiveness_over_delta([kind, kind], towers().types) == pytest.approx(
        distinctiveness_over_delta([kind], towers().types)
    )


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_ev_by_either_dv_keeps_the_order_of_rivals(name):
    """The weights move the numbers, not the verdict on a clear scene."""
    shot = one_tower(name, 8063)
    of, kind = data(shot), towers().type(name)
    beliefs = beliefs_of(rivals(name, shot.poses[name]), of)
    over_delta = distinctiveness_over_delta([kind], towers().types)
    for dv in (perceiver().dv, over_delta):
        values = {label: explanatory_value(b.support(), dv) for label, b in beliefs.items()}
        assert max(values, key=values.get) == "right"
    assert explanatory_value(beliefs["turned"].support(), over_delta) != explanatory_value(
        beliefs["turned"].support(), perceiver().dv
    )
