"""Sides of edges beside keypoints at a pose.

Expected where an image has any, matched apart from keypoints, and settled on.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, gamma_at, keypoint_of, one_sided, pose_before, ready, with_sides

from geometry.frames import from_rotation_translation, pose_error
from plogic.match.gamma.data import data_of
from plogic.match.learned.agreement import lobes_held
from plogic.match.learned.learned_match import matched, pose_of

COUNT = 30
SIDES = np.arange(0, COUNT, 2)


@cache
def both(seed=1):
    """A type, every other of whose features is the side of an edge, of colours of its own."""
    looks = np.random.default_rng(seed).integers(60, 200, (COUNT, 5))
    return ready(with_sides(one_sided(seed, COUNT, width=138), SIDES, looks))


def pose_of_seed(seed):
    return pose_before(np.random.default_rng(seed))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.lists(st.integers(0, COUNT - 1), unique=True))
def test_an_image_without_any_side_expects_none(seed, shown):
    thing, pose = both(), pose_of_seed(seed)
    data = gamma_at(thing.cloud, shown, pose)
    posed = pose_of(thing.index, pose, data, thing.kb)
    sided = np.isin(np.arange(COUNT), SIDES)
    assert posed.sided.tolist() == sided.tolist()
    awaited = set(shown) & set(SIDES.tolist())
    held = np.isin(np.arange(COUNT), lobes_held(thing.index, pose, CAMERA.f / thing.kb.f_ref))  # a lobe a feature
    assert held[sided].any()
    assert posed.in_lobe.tolist() == (held & (~sided | bool(awaited))).tolist()
    assert (posed.hit > 0).tolist() == posed.in_lobe.tolist()
    if awaited:  # what is left of it when some are explained still expects them
        rest = pose_of(thing.index, pose, data.only(~data.sided), thing.kb)
        assert rest.in_lobe.tolist() == held.tolist()
        assert rest.hit.tolist() == posed.hit.tolist()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.lists(st.integers(0, COUNT - 1), unique=True), st.integers(0, 2**COUNT - 1))
def test_keypoints_are_matched_as_without_sides(seed, shown, bits):
    """At a pose: the same matches, places and evidence of each, with the sides of edges and without them."""
    thing, pose = both(), pose_of_seed(seed)
    plain = ready(replace(thing.cloud.keypoints))
    points = np.flatnonzero(~np.isin(np.arange(COUNT), SIDES))
    data = gamma_at(thing.cloud, shown, pose)
    some = np.array([bits >> f & 1 for f in range(COUNT)], bool)
    free, hidden = some[: len(data.ids)], ~some
    mixed = matched(thing.index, pose_of(thing.index, pose, data, thing.kb), data, thing.kb, free, hidden)
    alone = matched(plain.index, pose_of(plain.index, pose, data, plain.kb), data, plain.kb, free, hidden[points])
    assert mixed.matches[points].tolist() == alone.matches.tolist()
    np.testing.assert_allclose(mixed.residual[points], alone.residual)
    np.testing.assert_allclose(mixed.sigma[points], alone.sigma)
    np.testing.assert_allclose(mixed.likeness[points], alone.likeness)
    assert np.isnan(mixed.across[points]).all()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(0, 2**COUNT - 1), st.integers(0, 2**COUNT - 1))
def test_sides_take_their_own_unless_these_are_claimed_or_they_are_hidden(seed, claimed, behind):
    thing, pose = both(), pose_of_seed(seed)
    data = gamma_at(thing.cloud, range(COUNT), pose)
    free, hidden = (np.array([bits >> f & 1 for f in range(COUNT)], bool) for bits in (claimed, behind))
    posed = matched(thing.index, pose_of(thing.index, pose, data, thing.kb), data, thing.kb, free, hidden)
    mine = np.isin(np.arange(COUNT), SIDES)
    expected = mine & free & ~hidden & posed.candidate
    assert (posed.matches[expected] == np.flatnonzero(expected)).sum() >= 0.9 * expected.sum() - 1
    assert (posed.matches[mine & ~expected] != np.flatnonzero(mine & ~expected)).all()
    found = mine & posed.detected
    assert not hidden[found].any()
    assert free[posed.matches[found]].all()
    assert data.sided[posed.matches[found]].all()
    taken = posed.matches[posed.detected]
    assert len(set(taken.tolist())) == len(taken)
    np.testing.assert_allclose(np.linalg.norm(posed.across[found], axis=1), 1.0)


def test_settling_on_sides_alone_moves_a_pose_to_where_their_edges_are():
    """Each lies anywhere along its edge; so a pose that is a little off is found by what they are off across it."""
    rng, errors = np.random.default_rng(6), []
    for seed in range(5):
        looks = rng.integers(60, 200, (60, 5))
        thing = ready(with_sides(one_sided(seed, 60, width=138), range(60), looks))
        truth = pose_before(rng)
        rows = [keypoint_of(thing.cloud, lobe, truth, number=lobe) for lobe in range(60)]
        slid = [
            replace(a, uv=tuple(np.array(a.uv) + rng.uniform(-2, 2) * np.array([-np.sin(a.angle), np.cos(a.angle)])))
            for a in rows
        ]
        start = from_rotation_translation(truth[:3, :3], truth[:3, 3] + rng.normal(0, 0.001, 3))
        posed = thing.index.settle(start, data_of(slid, CAMERA), thing.kb, rounds=4)
        assert (posed.matches == np.arange(60)).mean() > 0.8
        rotation, translation = pose_error(posed.camera_from_object, truth)
        errors.append((np.degrees(rotation), translation))
    assert np.max(errors, axis=0)[0] < 1.0
    assert np.max(errors, axis=0)[1] < 0.01


@pytest.mark.parametrize("shown", [[], [0], list(range(COUNT))])
def test_any_data_settle(shown):
    thing, pose = both(), pose_of_seed(3)
    posed = thing.index.settle(pose, gamma_at(thing.cloud, shown, pose), thing.kb)
    assert posed.detected.sum() <= len(shown)
    assert np.isfinite(posed.camera_from_object).all()
