"""Sides of edges that agree with coarse poses, against a loop over poses, appearances and sides."""

from __future__ import annotations

from math import cos, log, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, gamma_at, keypoint_of, one_sided, pose_before, ready, with_sides
from random_cloud import random_cloud, unit

from geometry.frames import transform_points
from kb.clouds.words import COLOURS, SIDE
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.gamma.side_looks import OFF
from plogic.match.learned.agreement import lobes_held
from plogic.match.learned.learned_refinement import side_fit
from plogic.match.learned.sides import ALONG, TURNED
from sensing.appearance import Appearance

SEEDS = st.integers(0, 9999)
GRANULARITY = CAMERA.f / 600.0
MOST = 60


def made(seed, features=14, lobes=22):
    """A type with keypoints and sides that is seen from its front, and some poses before it."""
    rng = np.random.default_rng(seed)
    axis = unit(np.array([0.0, 0, 1]) + 0.3 * rng.normal(size=(lobes, 3)))
    seen = {
        "axis": axis,
        "up": unit(np.cross(axis, rng.normal(size=(lobes, 3)))),
        "half_angle": rng.uniform(0.2, 0.9, lobes),
    }
    cloud = random_cloud(
        seed,
        features,
        lobes,
        width=138,
        r_min=np.full(lobes, 0.2),
        hit=rng.permutation(np.linspace(0.3, 0.9, lobes)),
        **seen,
    )
    looks = np.array([100, 140, 100, 140, 128]) + rng.integers(-8, 9, (lobes, 5))
    thing = ready(with_sides(cloud, range(0, features, 2), looks))
    return thing, np.array([pose_before(rng, rng.uniform(0.6, 1.2)) for _ in range(3)]), rng


def beside(thing, pose, rng, reach, count=30):
    """Sides near those that the pose expects: off, along, and a little turned."""
    lobes, rows = np.flatnonzero(thing.cloud.sided), []
    for number in range(count):
        one = keypoint_of(thing.cloud, int(rng.choice(lobes)), pose, number=number)
        off, along = rng.uniform(-1.5 * reach, 1.5 * reach), rng.uniform(-1.5, 1.5) * (ALONG + reach / 3)
        uv = (
            np.array(one.uv)
            + off * np.array([cos(one.angle), sin(one.angle)])
            + along * np.array([-sin(one.angle), cos(one.angle)])
        )
        looks = np.frombuffer(one.descriptor, np.uint8) + rng.integers(-22, 23, 5)
        angle = (one.angle + rng.uniform(-TURNED, TURNED)) % (2 * pi)
        rows.append(
            Appearance(
                f"a{number}",
                "sift",
                tuple(uv.tolist()),
                "made",
                angle=angle,
                descriptor=looks.astype(np.uint8).tobytes(),
            )
        )
    return data_of([row for row in rows if CAMERA.contains(np.array(row.uv))], CAMERA)


def expected(thing, pose):
    """Appearances of sides that a pose makes expect: their places, pixels and angles."""
    lobes = np.array([lobe for lobe in lobes_held(thing.index, pose, GRANULARITY) if thing.cloud.sided[lobe]], np.intp)
    at = transform_points(pose, thing.cloud.at[thing.cloud.feature[lobes]])
    uv, angle = CAMERA.project(at), screen_angle(thing.cloud.up[lobes] @ pose[:3, :3].T, at)
    return {int(lobe): (uv[i], angle[i]) for i, lobe in enumerate(lobes) if CAMERA.contains(uv[i])}


def agreeing(thing, lobe, uv, angle, data, reach):
    """Data that may be an appearance's."""
    found = []
    for d in np.flatnonzero(data.sided):
        du, dv = data.uv[d] - uv
        apart = data.looks[d, :COLOURS].astype(float) - thing.cloud.descriptor[lobe, 128 : 128 + COLOURS]
        near = (
            abs(du * cos(angle) + dv * sin(angle)) <= reach
            and abs(dv * cos(angle) - du * sin(angle)) <= ALONG + reach / 3
        )
        if near and abs(np.angle(np.exp(1j * (data.angle[d] - angle)))) < TURNED and np.linalg.norm(apart) < OFF:
            found.append(int(d))
    return found


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([3.0, 6.0, 12.0]))
def test_each_expected_side_in_the_image_has_one_that_agrees_where_there_is_one(seed, reach):
    thing, poses, rng = made(seed)
    data = beside(thing, poses[0], rng, reach)
    fit = side_fit(thing.index, poses, data, GRANULARITY, reach, MOST)
    assert len(fit.points) == len(poses) > 0
    for h, pose in enumerate(poses):
        awaited = expected(thing, pose)
        rows = {}
        for q in range(fit.points.shape[1]):
            for lobe in awaited:
                same = (fit.points[h, q] == thing.index.places[lobe]).all()
                if same and np.allclose(fit.across[h, q], [cos(awaited[lobe][1]), sin(awaited[lobe][1])]):
                    rows[lobe] = q
        assert sorted(rows) == sorted(awaited)
        rest = ~np.isin(np.arange(fit.points.shape[1]), list(rows.values()))
        assert not fit.weight[h, rest].any()
        for lobe, q in rows.items():
            agree = agreeing(thing, lobe, *awaited[lobe], data, reach)
            assert (fit.weight[h, q] > 0) == bool(agree)
            assert 0 <= fit.weight[h, q] <= thing.cloud.hit[lobe]
            assert fit.weight[h, q] == 0 or (fit.uv[h, q] == data.uv[agree]).all(axis=1).any()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS)
def test_a_pose_all_of_whose_sides_are_missed_is_worth_what_the_misses_say(seed):
    thing, poses, _ = made(seed)
    far = Appearance("a0", "sift", (2.0, 2.0), "made", angle=1.0, descriptor=bytes([255, 0, 255, 0, 128]))
    fit = side_fit(thing.index, poses, data_of([far], CAMERA), GRANULARITY, 6.0, MOST)
    misses = [sum(log(1 - thing.cloud.hit[lobe]) for lobe in expected(thing, pose)) for pose in poses]
    assert fit.worth.tolist() == pytest.approx(misses)
    assert not fit.weight.any()


@settings(max_examples=10, deadline=None, derandomize=True)
@given(SEEDS)
def test_the_right_pose_is_worth_more_than_others_and_each_pose_is_asked_for_itself(seed):
    rng = np.random.default_rng(seed)
    thing = ready(with_sides(one_sided(seed, 40, width=138), range(40), rng.integers(60, 200, (40, 5))))
    poses = np.array([pose_before(rng) for _ in range(4)])
    data = gamma_at(thing.cloud, range(40), poses[2])
    fit = side_fit(thing.index, poses, data, GRANULARITY, 4.0, MOST)
    assert fit.worth.argmax() == 2
    assert fit.worth[2] > 0
    for h in range(4):
        alone = side_fit(thing.index, poses[h : h + 1], data, GRANULARITY, 4.0, MOST)
        assert alone.worth.tolist() == pytest.approx([fit.worth[h]])
        assert sorted(alone.weight[0][alone.weight[0] > 0].tolist()) == pytest.approx(
            sorted(fit.weight[h][fit.weight[h] > 0].tolist())
        )


def test_the_surest_are_looked_for_where_there_are_many():
    rng = np.random.default_rng(0)
    count = 2 * MOST
    thing = ready(
        with_sides(one_sided(1, count, width=138, hit=rng.permutation(np.linspace(0.2, 0.9, count))), range(count))
    )
    pose = pose_before(rng)
    fit = side_fit(thing.index, pose[None], gamma_at(thing.cloud, range(count), pose), GRANULARITY, 6.0, MOST)
    assert fit.points.shape == (1, MOST, 3)
    held = lobes_held(thing.index, pose, GRANULARITY)
    surest = sorted(thing.cloud.hit[held])[-MOST:]
    rows = [int(np.flatnonzero((thing.index.places == point).all(axis=1))[0]) for point in fit.points[0]]
    assert sorted(thing.cloud.hit[rows].tolist()) == pytest.approx(surest)
    assert side_fit(
        thing.index, pose[None], gamma_at(thing.cloud, range(count), pose), GRANULARITY, 6.0, count
    ).points.shape == (1, len(held), 3)


def test_what_was_never_missed_may_be_missed():
    """A hit rate of 1 is measured over few pictures."""
    thing = ready(with_sides(one_sided(1, 40, width=138, hit=np.ones(40)), range(40)))
    pose = pose_before(np.random.default_rng(0))
    fit = side_fit(thing.index, pose[None], gamma_at(thing.cloud, range(38), pose), GRANULARITY, 4.0, MOST)
    assert np.isfinite(fit.worth).all()
    assert fit.worth[0] > 0


@pytest.mark.parametrize("width", [32, 128, 138])
def test_types_whose_keypoints_have_no_colours_have_no_sides(width):
    thing, poses = (
        ready(one_sided(1, 20, width=width)),
        np.array([pose_before(np.random.default_rng(i)) for i in range(3)]),
    )
    assert thing.index.looks.shape == (20, SIDE + 1)
    seen = Appearance("a0", "sift", (300.0, 200.0), "made", angle=1.0, descriptor=bytes(range(SIDE)))
    fit = side_fit(thing.index, poses, data_of([seen], CAMERA, width), GRANULARITY, 6.0, MOST)
    assert fit.worth.tolist() == [0.0] * 3
    assert fit.weight.shape == (3, 0)


@pytest.mark.parametrize("sided", [False, True])
def test_without_sides_there_are_none_and_they_say_nothing(sided):
    """Neither in the image nor of the type."""
    cloud = with_sides(one_sided(1, 20, width=138), range(0, 20, 2) if sided else [])
    thing, poses = ready(cloud), np.array([pose_before(np.random.default_rng(i)) for i in range(3)])
    data = gamma_at(cloud, range(1, 20, 2), poses[0])
    fit = side_fit(thing.index, poses, data, GRANULARITY, 6.0, MOST)
    assert fit.worth.tolist() == [0.0] * 3
    assert [some.shape for some in (fit.points, fit.uv, fit.across, fit.weight)] == [
        (3, 0, 3),
        (3, 0, 2),
        (3, 0, 2),
        (3, 0),
    ]
    nothing = side_fit(thing.index, poses[:0], data, GRANULARITY, 6.0, MOST)
    assert nothing.worth.shape == (0,)
