"""The perceptual cycle (§7) on synthetic Γ: what it accepts, why it stops, and what it writes down."""

from bisect import bisect_left
from dataclasses import replace
from itertools import combinations, count
from time import monotonic

import numpy as np
import pytest
from synthetic import (
    CAMERA,
    MIDDLE,
    belief_at,
    cycle_of,
    data,
    direction,
    is_right,
    one_before_the_other,
    perceiver,
    scene,
    side_by_side,
    task_of,
    upright,
)

from geometry.frames import look_at
from plogic.base import clock as deadline
from plogic.base.clock import Stopwatch
from plogic.cycle.choosing import reconsidered
from plogic.cycle.delta import Options
from plogic.cycle.judging import FEWEST, judge, refusal
from plogic.cycle.perception import attend, perceive
from plogic.cycle.state import Stable, State, considered
from plogic.match.judged.expectation import hidden_by
from plogic.match.judged.rivals import claims, overlap, same_place
from plogic.run.perceive import ranked
from sensing.appearance import Appearance, Gamma


def seen(stand, seed, **options):
    rng = np.random.default_rng(seed)
    shot = scene(rng, stand(rng), **options)
    return shot, cycle_of(shot.gamma)


@pytest.fixture(scope="module")
def hiding():
    """Five scenes in which t1 hides a part of t2: (shot, cycle)."""
    return [seen(one_before_the_other, seed) for seed in range(6000, 6005)]


@pytest.fixture(scope="module")
def apart():
    return [seen(side_by_side, seed) for seed in range(6000, 6003)]


def by_type(cycle):
    return {b.object_type.name: b for b in cycle.accepted}


def test_both_towers_are_accepted_where_they_stand(hiding, apart):
    assert min(len(hiding), len(apart)) > 0
    for shot, cycle in (*hiding, *apart):
        assert sorted(b.object_type.name for b in cycle.accepted) == ["t1", "t2"]
        for name, belief in by_type(cycle).items():
            assert is_right(name, belief.camera_from_object, shot.poses[name])
            assert belief.status == "accepted"
            assert belief.why


def test_hidden_misses_are_waived_and_ev_rises(hiding):
    """§3.8, Partial(x, y): ev(x) unchanged; ev(y | x) >= ev(y), and > where x hides what was missed."""
    assert len(hiding) > 0
    for _, cycle in hiding:
        front, back = by_type(cycle)["t1"], by_type(cycle)["t2"]
        hidden = hidden_by(back, front)
        assert not (back.detected & back.candidate & hidden).any()
        assert (back.candidate & hidden & ~back.detected).any()
        assert back.ev_reconsidered > back.ev
        assert front.ev_reconsidered == front.ev


def test_where_nothing_is_hidden_both_ev_stay(apart):
    assert all(cycle.accepted for _, cycle in apart)
    assert len(apart) > 0
    for _, cycle in apart:
        for belief in cycle.accepted:
            assert belief.ev == belief.ev_reconsidered


def test_no_two_accepted_share_volume_or_a_datum(hiding, apart):
    assert min(len(hiding), len(apart)) > 0
    for _, cycle in (*hiding, *apart):
        pairs = list(combinations(cycle.accepted, 2))
        assert pairs
        for one, other in pairs:
            assert not overlap(one, other)
            assert not set(claims(one, other)) & set(claims(other, one))


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_every_world_satisfies_a4(reading, hiding):
    shot, _ = hiding[0]
    delta, _, trace = perceiver().delta(shot.gamma, Options(reading=reading), Stopwatch())
    delta, ranking = ranked(delta, trace)
    assert ranking.worlds
    for world in ranking.worlds:
        for x, y in combinations(world.present, 2):
            assert not overlap(delta.beliefs[x], delta.beliefs[y])
    assert set(ranking.worlds[0].present) == {"h1", "h2"}


def test_accepted_hypotheses_meet_their_conditions(hiding, apart):
    assert min(len(hiding), len(apart)) > 0
    for _, cycle in (*hiding, *apart):
        assert cycle.accepted
        for belief in cycle.accepted:
            assert (belief.candidate & belief.detected).sum() >= FEWEST
            assert belief.ev_reconsidered > 0.0
            assert belief.worth > perceiver().models[belief.type].significance(belief)


def test_the_trace_names_every_step(hiding):
    assert len(hiding) > 0
    for _, cycle in hiding:
        events = [step.event for step in cycle.trace.steps]
        assert set(events) <= {"rank", "accept", "reject", "reconsider", "release", "stable"}
        assert [step.type for step in cycle.trace.steps if step.event == "rank"] == [
            row.type for row in cycle.attention
        ]
        assert events.count("accept") == len(cycle.accepted) + events.count("release")
        assert events.count("reject") + events.count("release") == len(cycle.rejected)
        assert events.count("reconsider") >= len(cycle.accepted)
        assert events[-1] == "stable"
        assert f"{len(cycle.accepted)} accepted" in cycle.trace.steps[-1].why
        assert all(step.why for step in cycle.trace.steps)
        assert all(step.type for step in cycle.trace.steps if step.event != "stable")
        assert [row["step"] for row in cycle.trace.document()] == list(range(1, len(events) + 1))


def test_what_is_rejected_has_a_reason_and_releases_its_data(hiding):
    rejected = [belief for _, cycle in hiding for belief in cycle.rejected]
    assert rejected
    assert {belief.status for belief in rejected} == {"rejected"}
    assert all(belief.why for belief in rejected)


def test_a_permuted_gamma_gives_the_same_objects(hiding):
    shot, cycle = hiding[1]
    order = np.random.default_rng(3).permutation(len(shot.gamma.appearances))
    again = by_type(cycle_of(Gamma(CAMERA, tuple(shot.gamma.appearances[i] for i in order))))
    assert again.keys() == by_type(cycle).keys()
    for name, belief in by_type(cycle).items():
        assert same_place(belief.object_type, belief.camera_from_object, again[name].camera_from_object)
        assert again[name].ev_reconsidered == pytest.approx(belief.ev_reconsidered, abs=0.02)


def test_the_same_gamma_twice_gives_the_same_trace(hiding):
    shot, cycle = hiding[2]
    assert cycle_of(shot.gamma).trace.document() == cycle.trace.document()


# --- it terminates, and finds nothing where there is nothing ---


def accepted_in(appearances):
    return cycle_of(Gamma(CAMERA, tuple(appearances))).accepted


def test_an_empty_gamma_is_the_empty_world():
    document = perceiver()(Gamma(CAMERA, ()))
    assert document["hypotheses"] == []
    assert [(w["probability"], w["present"], w["causes"]) for w in document["worlds"]] == [(1.0, [], {})]
    assert "unfinished" not in document


@pytest.mark.parametrize("kind", ["patch", "y_junction", "nobody_knows"])
def test_one_appearance_is_noise(kind):
    gamma = Gamma(CAMERA, (Appearance("a1", kind, (300.0, 200.0), "drawn"),))
    document = perceiver()(gamma)
    assert [w["present"] for w in document["worlds"]] == [[]]
    assert document["worlds"][0]["causes"] == {"a1": "noise"}


@pytest.mark.parametrize("number", [5, 20, 40, 80])
def test_pure_clutter_is_the_empty_world(number):
    for seed in range(3):
        shot = scene(np.random.default_rng(6100 + seed), {}, clutter=number)
        assert cycle_of(shot.gamma).accepted == ()


def test_a_regular_grid_of_patches_terminates():
    """The hardest clutter: windows of any wall anywhere, and no corner.

    What is seen in it must at least be consistent (A4).
    """
    grid = [Appearance(f"a{i}", "patch", (100.0 + 40 * (i % 8), 80.0 + 40 * (i // 8)), "drawn") for i in range(64)]
    cycle = cycle_of(Gamma(CAMERA, tuple(grid)))
    assert cycle.trace.steps[-1].event == "stable"
    assert len(cycle.accepted) <= 64 // FEWEST
    assert not any(overlap(x, y) for x, y in combinations(cycle.accepted, 2))


def test_everything_in_one_place_terminates():
    heap = [Appearance(f"a{i}", "l_junction", (300.0, 200.0), "drawn", arms=(0.0, 1.5)) for i in range(30)]
    assert accepted_in(heap) == ()


def test_one_tower_alone_is_one_object():
    for seed in range(6200, 6203):
        rng = np.random.default_rng(seed)
        name = ("t1", "t2")[seed % 2]
        shot = scene(rng, {name: side_by_side(rng)[name]})
        assert [b.object_type.name for b in cycle_of(shot.gamma).accepted] == [name]


# --- trap b: the phantom ---


def behind_the_tower(rng):
    """t1 at 4 m, and t2 9 m behind it on the line of sight: nothing of t2 is seen."""
    azimuth = rng.uniform(0, 2 * np.pi)
    eye = MIDDLE + 4.0 * direction(azimuth, np.radians(5))
    camera_from_world, away = look_at(eye, MIDDLE), direction(azimuth + np.pi, 0.0)
    return {"t1": camera_from_world @ upright(0, 0, 0.3), "t2": camera_from_world @ upright(*(9.0 * away[:2]), 1.0)}


@pytest.mark.parametrize("seed", [6300, 6301])
def test_b_a_fully_hidden_phantom_is_never_accepted(seed):
    """Its ev is +1, everything of it being hidden and nothing detected; it counts for nothing all the same."""
    rng = np.random.default_rng(seed)
    poses = behind_the_tower(rng)
    shot = scene(rng, poses, clutter=0)
    assert not any(name.startswith("t2") for name in shot.visible)
    task = task_of(shot.gamma)
    cycle = perceive(task, attend_to(shot.gamma))
    assert [b.object_type.name for b in cycle.accepted] == ["t1"]
    phantom = judge(task, cycle.accepted, belief_at("t2", poses["t2"], data(shot)), 0)
    assert phantom.ev_reconsidered == 1.0
    assert "detected" in refusal(task, State(accepted=cycle.accepted), phantom)


def attend_to(gamma):
    return attend(list(perceiver().models.values()), [a.type for a in gamma.appearances], perceiver().kb)


# --- deadlines ---


def test_a_deadline_that_is_past_stops_at_once_and_is_marked(apart):
    shot, _ = apart[0]
    document = perceiver()(shot.gamma, Options(end=monotonic() - 1.0))
    assert document["unfinished"] is True
    assert [h for h in document["hypotheses"] if h["status"] == "accepted"] == []
    assert document["trace"][-1]["event"] == "deadline"


def test_a_deadline_in_the_first_round_keeps_what_was_found(apart, monkeypatch):
    """A clock of our own, one tick a look.

    The least time with an answer is for the first type of the first round, and to make its best stable.
    """
    shot, _ = apart[0]
    attention = attend_to(shot.gamma)

    def by(end):
        ticks = count()
        monkeypatch.setattr(deadline, "monotonic", lambda: float(next(ticks)))
        return perceive(task_of(shot.gamma, end=float(end)), attention)

    least = bisect_left(range(1000), 1, key=lambda end: min(1, len(by(end).accepted)))  # more time never finds less
    for cycle in (by(least - 1), by(least)):
        assert cycle.unfinished
        assert [step.event for step in cycle.trace.steps[-2:]] == ["stable", "deadline"]
    assert [b.object_type.name for b in cycle.accepted] == [attention[0].type]


def test_time_enough_leaves_no_mark(apart):
    shot, cycle = apart[1]
    document = perceiver()(shot.gamma, Options(end=monotonic() + 600.0))
    assert "unfinished" not in document
    assert len([h for h in document["hypotheses"] if h["status"] == "accepted"]) == len(cycle.accepted)


# --- duplicates are merged before the program is written (§8) ---


def test_near_duplicates_of_what_is_considered_are_merged(apart):
    _shot, cycle = apart[0]
    nearly = cycle.accepted[0].camera_from_object.copy()
    nearly[0, 3] += 0.01
    twin = replace(cycle.accepted[0], camera_from_object=nearly, status="rival")
    assert considered([twin, twin], cycle.accepted) == []


def test_rivals_that_differ_are_kept_once_each(apart):
    _shot, cycle = apart[0]
    away = cycle.accepted[0].camera_from_object.copy()
    away[0, 3] += 1.5
    other = replace(cycle.accepted[0], camera_from_object=away, status="rival")
    assert considered([other, other, other], cycle.accepted) == [other]


@pytest.mark.parametrize("place", ["in view", "out of view"])
def test_what_does_not_hold_beside_the_others_is_released(place, apart):
    """Δi is made stable: what has an ev of at most 0, or none (0/0), is dropped, and the trace says so."""
    shot, cycle = apart[0]
    eye = MIDDLE + 4.0 * direction(0.7, np.radians(40))
    wrong = look_at(eye, MIDDLE)
    wrong[0, 3] += {"in view": 0.0, "out of view": 50.0}[place]
    belief = belief_at("t1", wrong, data(shot))
    assert (belief.ev is None) == (place == "out of view")
    assert belief.ev is None or belief.ev < 0.0
    some = (*cycle.accepted, belief)
    found = reconsidered(task_of(shot.gamma), Stable(some, some))
    assert [b.camera_from_object.tolist() for b in found.accepted] == [
        b.camera_from_object.tolist() for b in cycle.accepted
    ]
    assert [step.event for step in found.steps].count("release") == 1
    assert found.rejected[0].why
