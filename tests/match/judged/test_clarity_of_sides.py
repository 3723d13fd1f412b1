"""Evidence of what is printed and of the sides of edges.

Each kind is seen as clearly as it is, whatever becomes of the other.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready, with_sides

from plogic.match.judged.evidence import (
    CLEAR,
    LEAST_CLEAR,
    LEAST_HIT,
    MOST_HIT,
    clarities,
    clarity,
    clutter_density,
    evidence,
    hit_rates,
    kinds,
    log_share,
    match_density,
)

COUNT = 40
SIDED = np.arange(COUNT) % 2 == 0
BITS = st.integers(0, 2**COUNT - 1).map(lambda bits: np.array([bits >> f & 1 for f in range(COUNT)], bool))
SOME = st.lists(st.booleans(), min_size=COUNT, max_size=COUNT).map(np.array)


@cache
def thing():
    looks = np.random.default_rng(1).integers(60, 200, (COUNT, 5))
    return ready(with_sides(one_sided(1, COUNT, width=138), np.flatnonzero(SIDED), looks))


def seen(shown):
    """A hypothesis whose appearances ``shown`` (F,) were detected, and the data.

    One side more is far away, so that sides are looked for.
    """
    pose = pose_before(np.random.default_rng(5))
    data = gamma_at(thing().cloud, [*np.flatnonzero(shown).tolist(), 0], pose)
    data.uv[-1] = 3.0
    return thing().index.settle(pose, data, thing().kb, rounds=0), data


def by_hand(posed, hidden, of):
    expected = posed.candidate & ~hidden & of
    hoped = (posed.counted * posed.hit)[expected].sum()
    return min(1.0, max(LEAST_CLEAR, posed.counted[expected & posed.detected].sum() / hoped)) if expected.any() else 1.0


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SOME, BITS)
def test_each_kind_has_its_own_clarity(shown, hidden):
    posed, _ = seen(shown)
    assert [kind.tolist() for kind in kinds(posed)] == [(~SIDED).tolist(), SIDED.tolist()]
    points, sides = by_hand(posed, hidden, ~SIDED), by_hand(posed, hidden, SIDED)
    assert clarities(posed, hidden) == pytest.approx(np.where(SIDED, sides, points))
    assert clarity(posed, hidden, SIDED) == pytest.approx(sides)
    assert clarity(posed, hidden) == pytest.approx(by_hand(posed, hidden, np.ones(COUNT, bool)))
    assert hit_rates(posed, thing().kb, hidden) == pytest.approx(
        np.clip(posed.hit * np.where(SIDED, sides, points), LEAST_HIT, MOST_HIT)
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SOME, BITS)
def test_the_ratio_is_the_sum_of_the_formulas_and_both_priors(shown, hidden):
    posed, data = seen(shown)
    rates, near, counted = hit_rates(posed, thing().kb, hidden), match_density(posed, thing().kb), posed.counted
    ratio = CLEAR * (log(by_hand(posed, hidden, SIDED)) + log(by_hand(posed, hidden, ~SIDED)))
    for f in np.flatnonzero(posed.candidate & ~hidden):
        if posed.matches[f] < 0:
            ratio += counted[f] * log(1 - rates[f])
            continue
        usual = clutter_density(thing().kb, data)[posed.matches[f]]
        ratio += counted[f] * log((rates[f] * near[f] + (1 - rates[f]) * usual) / usual)
    found = evidence(posed, data, thing().kb, hidden)
    assert found.ratio == pytest.approx(ratio)
    used = posed.candidate & posed.detected & ~hidden
    freedom = log_share(posed.at[used], (counted / posed.sigma**2)[used], posed.middle, data.camera, posed.across[used])
    assert found.surplus == pytest.approx(ratio + freedom)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SOME)
def test_what_becomes_of_the_one_kind_changes_nothing_of_the_other(shown):
    one, other = seen(shown)[0], seen(shown | SIDED)[0]
    kb = thing().kb
    np.testing.assert_allclose(hit_rates(one, kb)[~SIDED], hit_rates(other, kb)[~SIDED])
    assert clarity(other, None, SIDED) >= clarity(one, None, SIDED)
    one, other = seen(shown)[0], seen(shown | ~SIDED)[0]
    np.testing.assert_allclose(hit_rates(one, kb)[SIDED], hit_rates(other, kb)[SIDED])


def test_where_no_kind_is_told_all_are_keypoints():
    posed, _ = seen(np.ones(COUNT, bool))
    plain = replace(posed, sided=None)
    assert [int(kind.sum()) for kind in kinds(plain)] == [COUNT, 0]
    assert clarities(plain).tolist() == pytest.approx([clarity(plain)] * COUNT)


def test_sides_that_are_found_add_evidence_and_sides_that_are_missed_take_some():
    points = np.array([not sided for sided in SIDED])
    none, half, whole = (
        evidence(*seen(points | (SIDED & (np.arange(COUNT) < upto))), thing().kb).ratio
        for upto in (0, COUNT // 2, COUNT)
    )
    assert none < half < whole


def test_what_is_off_along_its_edge_fixes_a_pose_less():
    """The share of poses that fit is greater than if each side were a point."""
    posed, data = seen(np.ones(COUNT, bool))
    points = replace(posed, across=np.full((COUNT, 2), np.nan))
    ratio, other = evidence(posed, data, thing().kb), evidence(points, data, thing().kb)
    assert ratio.ratio == pytest.approx(other.ratio)
    assert ratio.surplus > other.surplus
