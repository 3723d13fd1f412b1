"""Settling where angles count.

What is matched, how much that says, and that angles fix the tilt that places leave open.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import EASY, STRAIGHT, clouds, datum, flat_cap, picture_of, seen_from

from geometry.frames import from_rotation_translation, is_rigid, pose_error, rotation_angle, rotation_from_quat_xyzw
from geometry.poses.refine import refine_poses
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import verified
from plogic.match.judged.expectation import pose_of
from plogic.match.oriented.oriented_match import (
    DEVIATIONS,
    Held,
    Noise,
    matched_at,
    polished,
    refined,
)
from plogic.run.perceive import Perceiver

SIGMA, NOISE = EASY.turn, 2.0


def scene(kind=0, cell=30, roll=0.3):
    """A type's index, a pose, and the exact picture of all features that are expected there."""
    index = clouds().rows[kind]
    pose = seen_from(index, cell, roll)
    empty = data_of([], STRAIGHT)
    features = np.flatnonzero(pose_of(index.object_type, pose, empty, clouds().kb).candidate)
    return index, pose, features, picture_of(index, pose, features)


def match(index, pose, data, **more):
    return matched_at(index, pose, data, clouds().kb, index.allowed(data), **more)


def turned(appearances, by):
    """The same data at angles ``by`` radians off; NaN takes an angle away."""
    by = np.broadcast_to(by, len(appearances))
    return [replace(a, angle=None if np.isnan(b) else a.angle + float(b)) for a, b in zip(appearances, by, strict=True)]


def likeness(angle):
    """The normal density of an angle over the even one, 1 / 2π."""
    return np.exp(-0.5 * (angle / SIGMA) ** 2) / (np.sqrt(2.0 * np.pi) * SIGMA) * 2.0 * np.pi


@pytest.mark.parametrize("cell", [3, 30, 101])
def test_the_exact_picture_is_matched_feature_by_feature(cell):
    index, pose, features, appearances = scene(cell=cell)
    posed = match(index, pose, data_of(appearances, STRAIGHT))
    assert posed.matches[features].tolist() == list(range(len(features)))
    assert (posed.matches >= 0).sum() == len(features) > 10
    assert np.allclose(posed.residual[features], 0.0, atol=1e-6)
    assert np.allclose(posed.likeness[features], likeness(0.0), rtol=1e-3)
    assert (posed.likeness[~posed.detected] == 1.0).all()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.floats(-1.0, 1.0), st.integers(-2, 2))
def test_within_three_deviations_an_angle_is_right_and_says_as_much_as_its_bell(share, turns):
    index, pose, features, appearances = scene()
    off = 0.99 * DEVIATIONS * SIGMA * share
    posed = match(index, pose, data_of(turned(appearances, off + 2.0 * np.pi * turns), STRAIGHT))
    assert posed.matches[features].tolist() == list(range(len(features)))
    assert np.allclose(posed.likeness[features], likeness(off), rtol=2e-3)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.floats(1.02 * DEVIATIONS * SIGMA, 2.0 * np.pi - 1.02 * DEVIATIONS * SIGMA))
def test_at_a_wrong_angle_nothing_is_matched(off):
    index, pose, features, appearances = scene()
    appearances = [a for a, n in zip(appearances, range(len(features)), strict=True) if n % 2 == 0]
    wrong = match(index, pose, data_of(turned(appearances, off), STRAIGHT))
    near = np.array(
        [np.linalg.norm(np.array(a.uv) - wrong.uv, axis=1) <= clouds().kb.rates.match_tolerance for a in appearances]
    )
    alone = near.sum(axis=1) == 1  # beside another feature a datum may be that one's
    assert alone.any()
    assert not set(np.flatnonzero(alone).tolist()) & set(wrong.matches.tolist())


def test_without_an_angle_a_datum_is_right_at_any_and_says_nothing_by_it():
    index, pose, features, appearances = scene()
    silent = np.where(np.arange(len(features)) % 2 == 0, np.nan, 0.0)
    posed = match(index, pose, data_of(turned(appearances, silent), STRAIGHT))
    assert posed.matches[features].tolist() == list(range(len(features)))
    assert (posed.likeness[features[::2]] == 1.0).all()
    assert np.allclose(posed.likeness[features[1::2]], likeness(0.0), rtol=1e-3)


def test_of_two_data_at_one_place_the_one_at_the_right_angle_is_taken():
    index, pose, features, appearances = scene()
    beside = [replace(a, id=f"{a.id}w", angle=a.angle + 2.0) for a in appearances]
    posed = match(index, pose, data_of([*beside, *appearances], STRAIGHT))
    assert posed.matches[features].tolist() == list(range(len(features), 2 * len(features)))


def test_no_data_match_nothing():
    index, pose, _, _ = scene()
    posed = match(index, pose, data_of([], STRAIGHT))
    assert not posed.detected.any()
    assert (posed.likeness == 1.0).all()
    assert polished(index, posed, data_of([], STRAIGHT), clouds().kb, None) is None


def test_what_is_claimed_already_or_hidden_is_left_out():
    index, pose, features, appearances = scene()
    data = data_of(appearances, STRAIGHT)
    free = np.arange(len(features)) % 3 > 0
    posed = match(index, pose, data, free=free)
    assert set(posed.matches[posed.detected].tolist()) <= set(np.flatnonzero(free).tolist())
    hidden = np.zeros(len(index.points), bool)
    hidden[features[4:]] = True
    held = match(index, pose, data, hidden=hidden)
    assert polished(index, held, data, clouds().kb, hidden) is not None
    hidden[features[3:]] = True
    assert polished(index, held, data, clouds().kb, hidden) is None, "three are too few"


@pytest.mark.parametrize("number", [0, 3, 4, 8])
def test_a_pose_is_refined_on_four_matches_and_not_on_fewer(number):
    index, pose, features, _ = scene()
    data = data_of(picture_of(index, pose, features[:number]), STRAIGHT)
    new = polished(index, match(index, pose, data), data, clouds().kb, None)
    if number < 4:
        assert new is None
    else:
        assert np.allclose(new, pose, atol=1e-6)


def test_polishing_brings_a_pose_home():
    index, pose, _, appearances = scene()
    data = data_of(appearances, STRAIGHT)
    beside = pose.copy()
    beside[:3, :3] = pose[:3, :3] @ rotation_from_quat_xyzw([0.006, -0.008, 0.004, 1.0])
    beside[:3, 3] += [0.001, -0.0005, 0.01]
    posed = index.settle(beside, data, clouds().kb, rounds=4)
    assert np.allclose(posed.camera_from_object, pose, atol=1e-4)
    assert posed.detected.sum() == len(appearances)
    again = index.settle(posed, data, clouds().kb, rounds=2)
    assert np.array_equal(again.matches, posed.matches), "what is settled stays"
    assert np.array_equal(index.settle(beside, data, clouds().kb, rounds=0).camera_from_object, beside)


def test_the_cycle_settles_this_way_where_angles_count_and_the_old_way_where_not():
    index, pose, _, appearances = scene()
    data, kb = data_of(turned(appearances, 2.0), STRAIGHT), clouds().kb
    old = replace(kb, rates=replace(kb.rates, sigma_angle=None))
    by_places = Perceiver(old).models[index.object_type.name]
    strict, lax = index.settle(pose, data, kb, rounds=0), by_places.settle(pose, data, old, rounds=0)
    assert lax.likeness is None
    assert lax.detected.sum() == len(appearances) > 2 * strict.detected.sum()


def test_the_verified_are_distinct_and_best_first():
    index, pose, _, appearances = scene()
    data = data_of(appearances, STRAIGHT)
    elsewhere = pose.copy()
    elsewhere[0, 3] += 0.3
    found = verified(index, [elsewhere, pose, pose], data, clouds().kb)
    assert len(found) == 1
    assert found[0][0] > 0
    assert np.allclose(found[0][1].camera_from_object, pose, atol=1e-5)
    assert verified(index, [], data, clouds().kb) == []
    assert verified(index, [pose], data, clouds().kb, all_hidden) == []


def all_hidden(posed):
    return np.ones(len(posed.uv), bool)


def cap_scene(seed):
    """The cap seen nearly face on, a hundred pixels across, 2 pixels and ``SIGMA`` off: index, truth, start, data."""
    rng, index = np.random.default_rng(seed), flat_cap(seed % 3).rows[0]
    facing = np.diag([1.0, -1.0, -1.0])  # its z axis towards the camera
    tilt, more = rotation_from_quat_xyzw([*rng.normal(0.0, 0.06, 2), rng.normal(), 1.0]), rng.normal(0.0, 0.05, 2)
    pose = from_rotation_translation(facing @ tilt, [*rng.uniform(-0.1, 0.1, 2), 1.2])
    start = pose.copy()
    start[:3, :3] = rotation_from_quat_xyzw([*more, 0.0, 1.0]) @ pose[:3, :3]
    data = [
        datum(i, a.type, np.array(a.uv) + rng.normal(0.0, NOISE, 2), a.angle + rng.normal(0.0, SIGMA))
        for i, a in enumerate(picture_of(index, pose, range(len(index.points))))
    ]
    return index, pose, start, data_of(data, STRAIGHT)


def held(index, data, angle):
    rows = (index.points, index.turns, data.uv, angle, np.ones(len(index.points)))
    return Held(*(row[None] for row in rows))


def refined_by(index, start, data, angle, steps=20):
    return refined(start[None], held(index, data, angle), Noise(NOISE, SIGMA), STRAIGHT, steps=steps, robust=2.0)


def test_angles_fix_the_tilt_of_a_flat_cap():
    """Mean error of the rotation over seeds, refined on the same places from the same starts."""
    errors = {True: [], False: []}
    for seed in range(36):
        index, truth, start, data = cap_scene(seed)
        for with_angles, found in errors.items():
            angle = data.angle if with_angles else np.full(len(data.angle), np.nan)
            found.append(float(np.degrees(pose_error(refined_by(index, start, data, angle)[0], truth)[0])))
    with_angles, without = np.mean(errors[True]), np.mean(errors[False])
    assert with_angles < 0.9 * without, (with_angles, without)


def test_without_any_angles_refinement_is_that_of_places():
    for seed in range(4):
        index, _, start, data = cap_scene(seed)
        got = refined_by(index, start, data, np.full(len(data.angle), np.nan))
        weights = np.full((1, len(data.uv)), 1.0 / NOISE**2)
        places = refine_poses(start[None], index.points[None], data.uv[None], weights, STRAIGHT, 20, huber=2.0 * NOISE)[
            0
        ]
        assert np.allclose(got, places, atol=1e-7)


def test_exact_data_bring_the_cap_home_and_what_weighs_nothing_says_nothing():
    index, truth, start, data = cap_scene(1)
    exact = data_of(picture_of(index, truth, range(len(index.points))), STRAIGHT)
    weight = np.where(np.arange(len(data.uv)) % 3 == 0, 0.0, 1.0)
    wrong = np.where(weight > 0.0, exact.angle, exact.angle + 1.0)
    uv = np.where(weight[:, None] > 0.0, exact.uv, exact.uv + 40.0)
    rows = Held(index.points[None], index.turns[None], uv[None], wrong[None], weight[None])
    new = refined(start[None], rows, Noise(1.0, SIGMA), STRAIGHT, steps=40, robust=2.0)[0]
    assert is_rigid(new)
    assert float(rotation_angle(new[:3, :3].T @ truth[:3, :3])) < 1e-3
    assert np.allclose(new[:3, 3], truth[:3, 3], atol=1e-3)


def test_many_poses_are_refined_as_each_alone():
    index, _, start, data = cap_scene(2)
    starts = np.stack([start, start, start])
    starts[1, :3, 3] += 0.01
    starts[2, :3, 3] -= 0.005
    one = held(index, data, data.angle)
    three = Held(*(np.repeat(row, 3, axis=0) for row in one))
    together = refined(starts, three, Noise(NOISE, SIGMA), STRAIGHT, steps=10, robust=2.0)
    assert len(together) == 3
    for pose, mine in zip(starts, together, strict=True):
        assert np.allclose(
            refined(pose[None], one, Noise(NOISE, SIGMA), STRAIGHT, steps=10, robust=2.0)[0], mine, atol=1e-6
        )
