"""Which sides of edges a pose's own are (D8), read from the words of the definition by loops.

And how rare that is where they are.
"""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, keypoint_of, one_sided, pose_before, ready, with_sides
from random_cloud import random_cloud, unit

from geometry.frames import transform_points
from kb.clouds.words import COLOURS
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.gamma.side_looks import OFF, looks_fit
from plogic.match.learned.agreement import lobes_held
from plogic.match.learned.learned_match import pose_of
from plogic.match.learned.sides import ALONG, AROUND, FEW, TURNED, _one_to_one, side_matches
from sensing.appearance import Appearance

SEEDS = st.integers(0, 9999)
LOOKS = np.array([90, 140, 95, 135, 150])
REACH = 3.0


def angles(thing, pose, lobes):
    """(N,) radians on the screen towards the sides of lobes."""
    return screen_angle(
        thing.cloud.up[lobes] @ pose[:3, :3].T, transform_points(pose, thing.cloud.at[thing.cloud.feature[lobes]])
    )


def side(thing, pose, lobe, number=0, *, off=0.0, along=0.0, turned=0.0, looks=LOOKS):
    """A side that is so far from where an appearance is expected: across its line, along it, radians."""
    uv = CAMERA.project(transform_points(pose, thing.cloud.at[[thing.cloud.feature[lobe]]]))[0]
    angle = angles(thing, pose, [lobe])[0]
    place = uv + off * np.array([cos(angle), sin(angle)]) + along * np.array([-sin(angle), cos(angle)])
    descriptor = np.asarray(looks, np.uint8).tobytes()
    return Appearance(
        f"a{number}",
        "sift",
        tuple(place.tolist()),
        "made",
        angle=float((angle + turned) % (2 * pi)),
        descriptor=descriptor,
    )


def found_in(thing, pose, rows, free=None, reach=REACH):
    """The matches among some appearances; and those as data."""
    data = data_of(rows, CAMERA)
    posed = pose_of(thing.index, pose, data, thing.kb)
    lobes = lobes_held(thing.index, pose, CAMERA.f / thing.kb.f_ref)
    free = data.sided if free is None else data.sided & free
    reaches = np.broadcast_to(reach, len(thing.cloud.at))
    return side_matches(thing.index, posed, data, lobes[thing.cloud.sided[lobes]], free, reaches), data, posed


@pytest.fixture(scope="module")
def alone():
    """A type with one side, at a pose."""
    return ready(with_sides(one_sided(2, 1, width=138), [0])), pose_before(np.random.default_rng(4))


def crowd(seed, features=5, lobes=9):
    """A type whose features are a few pixels apart, some with several appearances, of their own looks and axes."""
    rng = np.random.default_rng(seed)
    axis = unit(np.array([0.0, 0, 1]) + 0.1 * rng.normal(size=(lobes, 3)))
    seen = {
        "axis": axis,
        "up": unit(np.cross(axis, rng.normal(size=(lobes, 3)))),
        "half_angle": np.full(lobes, 0.9),
        "r_min": np.full(lobes, 0.2),
    }
    cloud = random_cloud(seed, features, lobes, width=138, at=rng.uniform(-0.004, 0.004, (features, 3)), **seen)
    thing = ready(
        with_sides(cloud, range(features), LOOKS + rng.integers(-20, 21, (lobes, 5)), rng.integers(0, 60, lobes))
    )
    pose, rows = pose_before(rng, 0.8, 0.1), []
    for number in range(int(rng.integers(1, 25))):
        off, along = rng.uniform(-1.5 * REACH, 1.5 * REACH), rng.uniform(-1.5 * ALONG, 1.5 * ALONG)
        turned, looks = rng.uniform(-1.3 * TURNED, 1.3 * TURNED), LOOKS + rng.integers(-25, 26, 5)
        rows.append(
            side(thing, pose, int(rng.integers(lobes)), number, off=off, along=along, turned=turned, looks=looks)
        )
    return thing, pose, rows, rng


def as_seen(thing, pose, lobe, row):
    """Of a side and an appearance: pixels across and along, radians, whether it has the colours."""
    uv = CAMERA.project(transform_points(pose, thing.cloud.at[[thing.cloud.feature[lobe]]]))[0]
    angle, (du, dv) = angles(thing, pose, [lobe])[0], np.array(row.uv) - uv
    apart = (
        np.frombuffer(row.descriptor, np.uint8)[:COLOURS].astype(float)
        - thing.cloud.descriptor[lobe, 128 : 128 + COLOURS]
    )
    turned = abs(np.angle(np.exp(1j * (row.angle - angle))))
    return du * cos(angle) + dv * sin(angle), dv * cos(angle) - du * sin(angle), turned, np.linalg.norm(apart) < OFF


def may_be(thing, pose, lobe, row, reach):
    off, along, turned, coloured = as_seen(thing, pose, lobe, row)
    return abs(off) <= reach and abs(along) <= ALONG and turned < TURNED and coloured


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_one_side_a_feature_and_one_feature_a_side_and_none_is_left_that_could_be_one(seed):
    thing, pose, rows, rng = crowd(seed)
    free, reach = rng.random(len(rows)) < 0.8, rng.uniform(0.5, 1.5, 5) * REACH
    held = lobes_held(thing.index, pose, CAMERA.f / thing.kb.f_ref).tolist()
    found, data, _ = found_in(thing, pose, rows, free, reach)
    possible = {}
    for lobe in held:
        feature = int(thing.cloud.feature[lobe])
        for d in np.flatnonzero(free).tolist():
            if may_be(thing, pose, lobe, rows[d], reach[feature]):
                possible.setdefault((feature, d), []).append(lobe)
    pairs = list(zip(found.feature.tolist(), found.datum.tolist(), strict=True))
    assert set(pairs) <= set(possible)
    assert len(set(found.feature.tolist())) == len(set(found.datum.tolist())) == len(pairs)
    assert all(feature in found.feature or datum in found.datum for feature, datum in possible)
    for pair, off, across, rare in zip(pairs, found.off, found.across, found.rare, strict=True):
        offs = {lobe: as_seen(thing, pose, lobe, rows[pair[1]])[0] for lobe in possible[pair]}
        lobe = min(offs, key=lambda one: abs(offs[one] - off))
        angle = angles(thing, pose, [lobe])[0]
        assert off == pytest.approx(offs[lobe], abs=1e-6)
        assert across.tolist() == pytest.approx([cos(angle), sin(angle)])
        assert rare > 0
    assert data.sided.all()


def test_there_are_enough_such_pairs():
    counts = [len(found_in(thing, pose, rows)[0].feature) for thing, pose, rows, _ in map(crowd, range(30))]
    assert np.mean(counts) > 2


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.integers(0, 6), st.integers(-3, 3)), max_size=40, unique_by=lambda row: row[:2]
    )
)
def test_the_best_pair_is_taken_and_again_the_best_of_what_is_left(pairs):
    feature, datum, worth = (np.array([row[i] for row in pairs], np.intp) for i in range(3))
    taken = []
    for of, to, _ in sorted(pairs, key=lambda row: (-row[2], row[0], row[1])):
        if all(of != f and to != d for f, d in taken):
            taken.append((of, to))
    chosen = _one_to_one(feature, datum, worth.astype(float))
    assert sorted(zip(feature[chosen].tolist(), datum[chosen].tolist(), strict=True)) == sorted(taken)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.floats(-0.999 * ALONG, 0.999 * ALONG), st.floats(-0.999 * REACH, 0.999 * REACH))
def test_what_is_off_along_the_line_says_nothing(along, off):
    thing, pose = ready(with_sides(one_sided(2, 1, width=138), [0])), pose_before(np.random.default_rng(4))
    plain, _, _ = found_in(thing, pose, [side(thing, pose, 0)])
    found, _, _ = found_in(thing, pose, [side(thing, pose, 0, along=along, off=off)])
    assert found.feature.tolist() == found.datum.tolist() == [0]
    assert found.off.tolist() == pytest.approx([off], abs=1e-6)
    assert found.rare.tolist() == pytest.approx(plain.rare.tolist())


FAR = (0, 0, 255, 255, 150)


@pytest.mark.parametrize(
    ("changed", "taken"),
    [
        ({}, True),
        ({"off": 0.99 * REACH}, True),
        ({"off": 1.01 * REACH}, False),
        ({"off": -1.01 * REACH}, False),
        ({"along": 1.01 * ALONG}, False),
        ({"along": -1.01 * ALONG}, False),
        ({"turned": 0.99 * TURNED}, True),
        ({"turned": 1.01 * TURNED}, False),
        ({"turned": -1.01 * TURNED}, False),
        ({"turned": pi}, False),
        ({"looks": FAR}, False),
        ({"looks": (90 + int(0.9 * OFF), 140, 95, 135, 150)}, True),
        ({"looks": (90, 140, 95, 135 - int(OFF) - 1, 150)}, False),
        ({"looks": (90, 140, 95, 135, 20)}, True),  # another contrast is less likely, and possible
    ],
)
def test_another_place_another_way_facing_and_other_colours_are_not_taken(alone, changed, taken):
    found, _, _ = found_in(*alone, [side(*alone, 0, **changed)])
    assert found.datum.tolist() == ([0] if taken else [])


def test_what_is_claimed_is_not_taken(alone):
    rows = [side(*alone, 0), side(*alone, 0, 1, off=1.0)]
    assert found_in(*alone, rows)[0].datum.tolist() == [0]
    assert found_in(*alone, rows, np.array([False, True]))[0].datum.tolist() == [1]
    assert found_in(*alone, rows, np.zeros(2, bool))[0].datum.tolist() == []


def test_where_keypoints_have_no_colours_those_of_sides_do_not_count(alone):
    points = one_sided(2, 1)
    rows = [side(*alone, 0, looks=FAR), keypoint_of(points, 0, alone[1], number=1)]
    assert found_in(*alone, rows)[0].datum.tolist() == [0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, 40))
def test_it_is_as_much_less_rare_as_more_looks_as_right_around_it(seed, count):
    """By a loop over what lies about: of what is free, faces so, has the colours, is near, and not on the line."""
    rng = np.random.default_rng(seed)
    thing, pose = ready(with_sides(one_sided(2, 1, width=138), [0])), pose_before(np.random.default_rng(4))
    rows = [side(thing, pose, 0)]
    for number in range(count):
        off, along = rng.uniform(-1.2 * AROUND, 1.2 * AROUND, 2)
        along += np.sign(along) * ALONG * (abs(off) <= REACH)
        turned, looks = rng.uniform(-2 * TURNED, 2 * TURNED) * rng.random(), LOOKS + rng.integers(-25, 26, 5)
        rows.append(side(thing, pose, 0, number + 1, off=off, along=along, turned=turned, looks=looks))
    free = np.append(True, rng.random(count) < 0.8)
    others = 0
    for row, mine in zip(rows[1:], free[1:], strict=True):
        off, along, turned, coloured = as_seen(thing, pose, 0, row)
        others += mine and abs(off) > REACH and hypot(off, along) < AROUND and turned < TURNED and coloured
    (found, data, _), (plain, one, _) = found_in(thing, pose, rows, free), found_in(thing, pose, rows[:1])
    assert found.datum.tolist() == [0]
    lobe = np.flatnonzero(thing.cloud.sided)[:1]
    fits = [
        looks_fit(thing.index.looks[lobe], data.looks[:1], np.zeros(1, np.float32), of.contrasts)[0]
        for of in (data, one)
    ]
    assert found.rare[0] == pytest.approx(
        plain.rare[0] * FEW / (FEW + others) * fits[0] / fits[1]
    )  # the more edges are as bright, the less it says


@pytest.mark.parametrize("name", ["turned", "looks"])
def test_what_fits_better_is_rarer(alone, name):
    """By the direction it faces, either way; by its colours and its contrast."""
    steps = np.linspace(0.0, 0.95, 12)
    looks = [(LOOKS + np.rint(step * OFF * np.array([0.5, -0.5, 0.5, 0.5, -1.0]))).astype(int) for step in steps]
    several = [steps * TURNED, -steps * TURNED] if name == "turned" else [looks]
    assert {len(values) for values in several} == {12}
    for values in several:
        rare = [float(found_in(*alone, [side(*alone, 0, **{name: value})])[0].rare[0]) for value in values]
        assert (np.diff(rare) < 0).all()


def test_of_several_that_look_alike_the_nearest_to_the_line_is_taken_and_of_one_line_the_best_looking(alone):
    rows = [
        side(*alone, 0, i, off=off, along=along) for i, (off, along) in enumerate([(1.5, 0.0), (-0.4, 3.0), (2.0, 0.0)])
    ]
    assert found_in(*alone, rows)[0].datum.tolist() == [1]
    rows = [side(*alone, 0, i, along=float(i), turned=turned) for i, turned in enumerate([0.2, -0.1, 0.02])]
    assert found_in(*alone, rows)[0].datum.tolist() == [2]


def test_without_lobes_or_sides_there_are_none(alone):
    thing, pose = alone
    found, data, posed = found_in(thing, pose, [side(thing, pose, 0)])
    assert found.pattern == 0.0
    nothing = side_matches(thing.index, posed, data, np.zeros(0, np.intp), data.sided, np.full(1, REACH))
    none = side_matches(
        thing.index, posed, data.only(~data.sided), np.zeros(1, np.intp), np.zeros(0, bool), np.full(1, REACH)
    )
    for empty in (nothing, none):
        assert [len(getattr(empty, name)) for name in ("feature", "datum", "off", "across", "rare")] == [0] * 5
        assert empty.across.shape == (0, 2)
