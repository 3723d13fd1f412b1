"""Evidence of learned types: the kept share of the hit rates, densities against chance, the formula of §8."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from synthetic import camera_pose, data, posed_at, scene

from plogic.cycle.perception import attend
from plogic.match.judged.evidence import (
    CLEAR,
    LEAST_CLEAR,
    LEAST_HIT,
    MOST_HIT,
    clarity,
    clutter_density,
    density,
    evidence,
    hit_rates,
    log_share,
    match_density,
    sigmas,
)
from plogic.match.learned.agreement import ANGLES, SIZES
from plogic.match.learned.keypoints import NTH
from plogic.match.learned.learned_match import AROUND, BY_CHANCE, GROWTH, RAREST, TURNS

EXACT = (0.9 * 2 * ANGLES / (sqrt(2 * pi) * TURNS) + 0.1) * (0.9 * 2 * SIZES / (sqrt(2 * pi) * GROWTH) + 0.1)
"""How much likelier the very angle and size are of what is right than of what merely may be."""


@pytest.fixture(scope="module")
def thing():
    return ready(one_sided(1, 30))


@pytest.fixture(scope="module")
def pose():
    return pose_before(np.random.default_rng(5))


def settled(thing, pose, shown, noise=0.3):
    """A hypothesis whose appearances ``shown`` were detected."""
    of = gamma_at(thing.cloud, shown, pose)
    of.uv[:] += np.random.default_rng(0).normal(0, noise, of.uv.shape)
    return thing.index.settle(pose, of, thing.kb, rounds=0), of


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 30))
def test_clarity_is_what_was_found_of_what_was_hoped_for(count):
    thing, pose = ready(one_sided(1, 30)), pose_before(np.random.default_rng(5))
    posed, _ = settled(thing, pose, range(count))
    expected, found = posed.candidate, posed.candidate & posed.detected
    shares = posed.counted
    assert clarity(posed) == pytest.approx(
        min(1.0, max(LEAST_CLEAR, shares[found].sum() / (shares * posed.hit)[expected].sum()))
    )
    assert LEAST_CLEAR <= clarity(posed) <= 1.0
    rates = hit_rates(posed, thing.kb)
    assert ((rates >= LEAST_HIT) & (rates <= MOST_HIT)).all()
    assert rates[expected] == pytest.approx(np.clip(posed.hit * clarity(posed), LEAST_HIT, MOST_HIT)[expected])


def test_clarity_is_the_most_likely_share_where_all_rates_are_one(thing, pose):
    posed, _ = settled(thing, pose, range(12))
    posed = replace(posed, hit=np.full(30, 0.7))
    worth, tried = posed.counted, np.linspace(0.01, 1, 2000)
    found, missed = (worth[posed.candidate & some].sum() for some in (posed.detected, ~posed.detected))
    likely = found * np.log(0.7 * tried) + missed * np.log(1 - 0.7 * tried)
    assert clarity(posed) == pytest.approx(tried[likely.argmax()], abs=1e-3)


def test_what_is_hidden_is_not_hoped_for(thing, pose):
    posed, _ = settled(thing, pose, range(12))
    hidden = np.arange(30) >= 12
    assert clarity(posed, hidden) > clarity(posed)
    assert clarity(posed, np.ones(30, bool)) == 1.0


def test_types_written_by_hand_are_as_before():
    rng = np.random.default_rng(3)
    pose = camera_pose(rng)
    posed = posed_at("t1", pose, data(scene(rng, {"t1": pose})))
    from synthetic import towers

    assert clarity(posed) == 1.0
    assert hit_rates(posed, towers()).tolist() == [towers().rates.hit[f.type] for f in posed.object_type.features]
    np.testing.assert_array_equal(match_density(posed, towers()), density(posed.residual, sigmas(posed, towers())))


def test_a_match_of_a_keypoint_counts_against_clutter_that_looks_as_right(thing, pose):
    """No other keypoint looks right here.

    Then against the share of usual clutter that has the angle, the size, and looks so right.
    """
    posed, of = settled(thing, pose, range(20))
    near, usual = match_density(posed, thing.kb), clutter_density(thing.kb, of)
    here = np.maximum(
        usual, of.namesakes / (of.camera.width * of.camera.height)
    )  # the image may hold more of a word than is usual
    for f in range(30):
        sigma = posed.sigma[f]
        n = exp(-0.5 * (posed.residual[f] / sigma) ** 2) / (2 * pi * sigma**2)
        says = EXACT * n / (RAREST * BY_CHANCE) * (usual / here)[posed.matches[f]]
        assert near[f] == (0.0 if posed.matches[f] < 0 else pytest.approx(says, rel=1e-3))


def test_what_is_everywhere_around_says_little(thing, pose):
    """Copies of a keypoint within reach, out of place: the match of its feature counts the less, the more there are.

    No other does.
    """
    before, of = settled(thing, pose, range(20))
    first = int(before.matches[0])
    usual, counts = clutter_density(thing.kb, of)[first], []
    assert first == 0
    for copies in (1, 4):
        rows = [*range(20), *[0] * copies]
        crowd = gamma_at(thing.cloud, rows, pose)
        crowd.uv[:20] = of.uv
        crowd.uv[20:] += AROUND / 2 * np.column_stack([np.cos(np.arange(copies)), np.sin(np.arange(copies))])
        posed = thing.index.settle(pose, crowd, thing.kb, rounds=0)
        assert posed.matches.tolist() == before.matches.tolist()
        counts.append(posed.likeness[0])
        here = max(usual, crowd.namesakes[first] / (crowd.camera.width * crowd.camera.height))
        chance = BY_CHANCE * copies / NTH * here  # so many look as right, of the most that are known
        assert posed.likeness[0] == pytest.approx(EXACT * usual / (copies / (pi * AROUND**2) + chance), rel=1e-3)
        others, same = before.matches[1:20], crowd.types[first]
        word = np.array([crowd.types[m] == same for m in others])
        np.testing.assert_allclose(posed.likeness[1:20][~word], before.likeness[1:20][~word])
        assert (posed.likeness[1:20][word] <= before.likeness[1:20][word]).all()
    assert before.likeness[0] > counts[0] > counts[1]


def test_the_ratio_is_the_sum_of_the_formulas(thing, pose):
    """Each feature as much as it is counted, and the prior of clarity.

    The surplus is that times the share of poses that fit.
    """
    posed, of = settled(thing, pose, range(20))
    rates, near, shares, gains, misses = (
        hit_rates(posed, thing.kb),
        match_density(posed, thing.kb),
        posed.counted,
        [],
        [],
    )
    for f in np.flatnonzero(posed.candidate):
        if posed.matches[f] < 0:
            misses.append(shares[f] * log(1 - rates[f]))
            continue
        clutter = thing.kb.rates.clutter.get(of.types[posed.matches[f]], 1.0) / (of.camera.width * of.camera.height)
        gains.append(shares[f] * log((rates[f] * near[f] + (1 - rates[f]) * clutter) / clutter))
    assert len(gains) > 10
    assert shares.min() < 1.0
    found = evidence(posed, of, thing.kb)
    assert found.ratio == pytest.approx(sum(gains) + sum(misses) + CLEAR * log(clarity(posed)))
    used = posed.candidate & posed.detected
    freedom = log_share(posed.at[used], shares[used] / posed.sigma[used] ** 2, posed.middle, of.camera)
    assert found.surplus == pytest.approx(found.ratio + freedom)
    assert freedom < -10.0


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 2**30 - 1))
def test_what_is_hidden_says_nothing_also_to_freedom(bits):
    thing, pose = ready(one_sided(1, 30)), pose_before(np.random.default_rng(5))
    posed, of = settled(thing, pose, range(20))
    hidden = np.array([bits >> f & 1 for f in range(30)], bool)
    rates, near, shares = hit_rates(posed, thing.kb, hidden), match_density(posed, thing.kb), posed.counted
    used = posed.candidate & posed.detected & ~hidden
    clutter = clutter_density(thing.kb, of, posed.matches[used])
    gain = shares[used] * np.log((rates[used] * near[used] + (1 - rates[used]) * clutter) / clutter)
    miss = (shares * np.log(1 - rates))[posed.candidate & ~posed.detected & ~hidden]
    found = evidence(posed, of, thing.kb, hidden)
    assert found.ratio == pytest.approx(gain.sum() + miss.sum() + CLEAR * log(clarity(posed, hidden)))
    assert found.surplus - found.ratio == pytest.approx(
        log_share(posed.at[used], (shares / posed.sigma**2)[used], posed.middle, of.camera)
    )


def test_more_detections_are_more_evidence(thing, pose):
    ratios = [evidence(*settled(thing, pose, range(count)), thing.kb).ratio for count in (4, 10, 20, 30)]
    assert ratios == sorted(ratios)


def test_attention_goes_to_the_type_whose_words_are_there():
    from random_cloud import random_words

    words, mine = (
        random_words(),
        [ready(one_sided(seed, 12, word=np.full(12, seed)), name=f"t{seed}") for seed in (1, 2)],
    )
    rows = attend(
        [thing.index for thing in mine], [words.names[2]] * 12, replace(mine[0].kb, appearance_types=words.names)
    )
    assert [row.type for row in rows] == ["t2", "t1"]
    assert rows[0].rank == pytest.approx(1.0)
    assert rows[1].rank == 0.0
    assert rows[0].within_cell == rows[0].rank
