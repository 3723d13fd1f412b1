"""The agreement of pairs with poses, votes and one-to-one choice, each against a loop over all."""

from math import acos, atan2, exp, hypot, inf, log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, gamma_at, keypoint_of, one_sided, pose_before, ready, viewpoint
from random_cloud import random_cloud

from geometry.frames import transform_points
from plogic.match.gamma.data import centre_of, data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.learned.agreement import ANGLES, ASIDE, GRAZING, SIZES, Agreement, agreement, held_by, votes
from plogic.match.learned.keypoints import Pairs, pairs_of
from plogic.match.learned.learned_poses import generate

SINGLE = 5e-4
"""Pixels: a place in the image, of some hundred pixels, in single precision after a rotation and a division."""


def pairs(datum, lobe, weight=None):
    return Pairs(datum, lobe, np.ones(len(datum)) if weight is None else weight)


def residuals(found, count):
    """(H, P) pixels, inf where a pair contradicts."""
    result = np.full((len(found.tolerance), count), inf)
    result[found.pose, found.pair] = found.off
    return result


def residual_by_hand(index, pose, lobe, datum, data, tolerance):
    cloud, f = index.cloud, data.camera.f
    place = cloud.at[cloud.feature[lobe]]
    x, y, z = transform_points(pose, place[None])[0]
    if z <= 1e-6:
        return inf
    u, v = data.ideal[datum] - centre_of(data.camera)
    off = hypot(f * x / z - u, f * y / z - v) * tolerance / (tolerance + 2 * cloud.sigma[cloud.feature[lobe]] * f / z)
    line = viewpoint(pose) - place
    aside = acos(np.clip(line @ cloud.axis[lobe] / np.linalg.norm(line), -1, 1))
    if off > tolerance or aside >= min(cloud.half_angle[lobe] + ASIDE, GRAZING):
        return inf
    if abs(log(cloud.size[lobe] * f / z / data.scale[datum])) >= SIZES:
        return inf
    step = 1e-6 * (pose[:3, :3] @ cloud.up[lobe])
    a, b = (np.array([p[0] / p[2], p[1] / p[2]]) for p in (np.array([x, y, z]), np.array([x, y, z]) + step))
    turned = (atan2(*(b - a)[::-1]) - data.angle[datum] + pi) % (2 * pi) - pi
    return off if abs(turned) < ANGLES else inf


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.02, 0.3), st.floats(0.5, 6.0))
def test_agreement_is_what_a_loop_over_poses_and_pairs_says(seed, share, pixels):
    rng = np.random.default_rng(seed)
    thing = ready(random_cloud(seed, 8, 16, half_angle=rng.uniform(0.2, 1.5, 16)))
    truth = pose_before(rng)
    data = gamma_at(thing.cloud, rng.integers(0, 16, 20), truth)
    poses = np.stack(
        [truth, *(pose_before(rng, rng.uniform(0.5, 1.2)) for _ in range(3)), truth @ np.diag([1.0, -1, -1, 1])]
    )
    lobes = np.concatenate([rng.integers(0, 16, 30), np.arange(16)])
    some = pairs(rng.integers(0, 20, 46), lobes)
    found = agreement(thing.index, poses, some, data, share, pixels)
    assert residuals(found, len(some)).shape == (5, 46)
    for h, pose in enumerate(poses):
        depth = transform_points(pose, thing.index.centre[None])[0, 2]
        assert found.tolerance[h] == pytest.approx(share * thing.index.diameter * data.camera.f / depth + pixels)
        for p in range(len(some)):
            expected = residual_by_hand(thing.index, pose, lobes[p], some.datum[p], data, found.tolerance[h])
            assert residuals(found, len(some))[h, p] == pytest.approx(expected, abs=SINGLE)


def test_a_scene_agrees_with_its_own_pose_wholly():
    thing, rng = ready(one_sided()), np.random.default_rng(1)
    pose = pose_before(rng)
    lobes = np.arange(24)
    own = pairs(lobes, lobes)
    found = agreement(thing.index, pose[None], own, gamma_at(thing.cloud, lobes, pose), 0.0, 1.0)
    assert residuals(found, 24).max() < 0.01
    assert votes(found, own)[0] == pytest.approx(24, abs=0.01)
    for spoilt in ({"angle": 1.0}, {"scale": 2.0}, {"ideal": 30.0}):
        data = gamma_at(thing.cloud, lobes, pose)
        for name, much in spoilt.items():
            getattr(data, name)[:] = getattr(data, name) * much if name == "scale" else getattr(data, name) + much
        assert not len(agreement(thing.index, pose[None], own, data, 0.0, 1.0).pose)


def test_the_angle_on_the_screen_is_that_of_a_short_step():
    rng = np.random.default_rng(2)
    at, step = rng.uniform([-1, -1, 1], [1, 1, 4], (50, 3)), rng.normal(size=(50, 3))
    there = at + 1e-7 * step
    moved = there[:, :2] / there[:, 2:] - at[:, :2] / at[:, 2:]
    np.testing.assert_allclose(screen_angle(step, at), np.arctan2(moved[:, 1], moved[:, 0]), atol=1e-5)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(1, 14))
def test_votes_and_the_choice_of_one_each_are_those_of_loops(seed, count):
    rng = np.random.default_rng(seed)
    datum, feature = rng.integers(0, 5, count), rng.integers(0, 4, count)
    some = pairs(datum, np.zeros(count, np.intp), rng.uniform(0.1, 1, count))
    residual = np.where(rng.random((3, count)) < 0.4, inf, rng.uniform(0, 6, (3, count)))
    agree = np.nonzero(np.isfinite(residual))
    found = Agreement(*agree, residual[agree], rng.uniform(4, 8, 3))
    off = residual / found.tolerance[:, None]
    worth = [[some.weight[p] * exp(-2 * off[h, p] ** 2) for p in range(count)] for h in range(3)]
    expected = [sum(max(row[p] for p in range(count) if datum[p] == d) for d in set(datum.tolist())) for row in worth]
    np.testing.assert_allclose(votes(found, some), expected)
    held = held_by(found, some, feature)
    kept = np.zeros((3, count))
    kept[held.pose, held.pair] = held.weight
    for h in range(3):
        row = np.array([some.weight[p] * exp(-0.5 * (1.5 * off[h, p]) ** 2) for p in range(count)])
        for owner in (datum, feature):
            row = np.array(
                [
                    w if w == max(row[q] for q in range(count) if owner[q] == owner[p]) else 0.0
                    for p, w in enumerate(row)
                ]
            )
        np.testing.assert_allclose(kept[h], row)
        chosen = np.flatnonzero(kept[h])
        assert len(set(datum[chosen].tolist())) == len(set(feature[chosen].tolist())) == len(chosen)
    np.testing.assert_allclose(held.sums(3), kept.sum(axis=1))
    of_pairs = rng.normal(size=(count, 2))
    np.testing.assert_allclose(held.sums(3, of_pairs), kept @ of_pairs)


def test_descriptors_of_another_width_pair_with_nothing():
    thing = ready(random_cloud())
    others = [
        keypoint_of(random_cloud(width=32), lobe, pose_before(np.random.default_rng(0)), number=lobe)
        for lobe in range(6)
    ]
    data = data_of(others, CAMERA)
    assert not data.described.any()
    assert len(pairs_of(thing.index, data)) == 0
    assert generate(thing.index, data, thing.kb) == []
    assert len(pairs_of(thing.index, gamma_at(thing.cloud, [], np.eye(4)))) == 0
