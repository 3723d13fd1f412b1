"""What looks right at a pose, by a loop over all features, appearances and keypoints.

And how rare that is where it is.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, exp, log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, keypoint_of, one_sided, pose_before, ready, viewpoint
from random_cloud import random_cloud

from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.judged.evidence import clutter_density
from plogic.match.learned.agreement import ANGLES, ASIDE, GRAZING, SIZES, lobes_about
from plogic.match.learned.keypoints import FARTHEST, NTH
from plogic.match.learned.learned_match import (
    AROUND,
    AS_RIGHT,
    BY_CHANCE,
    GROWTH,
    LOOSER,
    POWER,
    RAREST,
    SAME,
    TURNS,
    likeness,
    pose_of,
    right_pairs,
)

FEATURES = 8


def scene(seed):
    """A type of which appearances look alike, at a pose, among keypoints of it that are anywhere near."""
    rng = np.random.default_rng(seed)
    look = np.clip(rng.integers(0, 256, 128) + rng.normal(0, 14, (20, 128)), 0, 255).astype(np.uint8)
    cloud = random_cloud(
        seed, FEATURES, 20, descriptor=look, half_angle=rng.uniform(0.2, 1.5, 20), size=np.full(20, 0.015)
    )
    thing, pose = ready(cloud), pose_before(rng)
    lobes = rng.integers(0, 20, 18)
    data = gamma_at(cloud, lobes, pose)
    data.uv[:] = CENTRE + rng.uniform(-40, 40, data.uv.shape)
    data.angle[:] += rng.normal(0, 0.4, 18)
    posed = replace(pose_of(thing.index, pose, data, thing.kb), uv=CENTRE + rng.uniform(-40, 40, (FEATURES, 2)))
    return thing, posed, data, rng


CENTRE = np.array([320.0, 240.0])


def about(thing, posed, lobe):
    cloud = thing.cloud
    line = viewpoint(posed.camera_from_object) - cloud.at[cloud.feature[lobe]]
    aside = acos(np.clip(line @ cloud.axis[lobe] / np.linalg.norm(line), -1, 1))
    return aside <= min(cloud.half_angle[lobe] + ASIDE, GRAZING)


def how_right(thing, posed, data, lobe, datum):
    """How far apart the descriptors are (of the farthest) and how well angle and size fit.

    None where it does not look right.
    """
    cloud, at = thing.cloud, posed.at[thing.cloud.feature[lobe]]
    grown = log(cloud.size[lobe] * data.camera.f / at[2] / data.scale[datum])
    turned = float(screen_angle(posed.camera_from_object[:3, :3] @ cloud.up[lobe], at)) - data.angle[datum]
    turned = (turned + pi) % (2 * pi) - pi
    apart = np.linalg.norm(cloud.descriptor[lobe].astype(float) - data.descriptors[datum]) / (LOOSER * FARTHEST)
    if abs(grown) >= SIZES or abs(turned) >= ANGLES or apart >= 1:
        return None
    return apart, against_even(turned, TURNS, ANGLES) * against_even(grown, GROWTH, SIZES)


def against_even(off, sigma, most):
    """Nine tenths normal and one tenth even, over even in [-most, most]."""
    return (0.9 * exp(-0.5 * (off / sigma) ** 2) / (sqrt(2 * pi) * sigma) + 0.1 / (2 * most)) * 2 * most


def by_loop(thing, posed, data, features, free, reach):
    """{(feature, datum): {lobe by which it looks right: how right}}."""
    found = {}
    for lobe in range(len(thing.cloud.feature)):
        feature = int(thing.cloud.feature[lobe])
        if feature not in features or not about(thing, posed, lobe):
            continue
        for datum in np.flatnonzero(free):
            near = np.linalg.norm(data.uv[datum] - posed.uv[feature]) <= reach
            how = how_right(thing, posed, data, lobe, datum) if near else None
            if how is not None:
                found.setdefault((feature, int(datum)), {})[lobe] = how
    return found


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(0, 2**FEATURES - 1), st.integers(0, 2**18 - 1), st.floats(3.0, 60.0))
def test_right_pairs_are_those_of_a_loop_among_what_is_free(seed, some, bits, reach):
    thing, posed, data, _ = scene(seed)
    features = np.flatnonzero([some >> f & 1 for f in range(FEATURES)])
    free = np.array([bits >> d & 1 for d in range(18)], bool)
    found = right_pairs(thing.index, posed, data, near(thing, posed), features, free, reach)
    expected = by_loop(thing, posed, data, features, free, reach)
    rows = list(zip(found.feature.tolist(), found.datum.tolist(), strict=True))
    assert len(rows) == len(set(rows))
    ways = {row: set() for row in rows}
    for pair, lobe in zip(found.pair.tolist(), found.lobe.tolist(), strict=True):
        ways[rows[pair]].add(lobe)
    assert ways == {row: set(by) for row, by in expected.items()}
    for row, apart, fit in zip(rows, found.apart, found.fit, strict=True):
        assert (apart, fit) == pytest.approx(min(expected[row].values()), rel=1e-4)
    held = np.arange(0, 20, 3)
    assert found.held(held).tolist() == [bool(ways[row] & set(held.tolist())) for row in rows]


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_lobes_about_are_those_that_hold_the_direction_of_view_or_nearly(seed):
    thing, posed, _, _ = scene(seed)
    expected = [lobe for lobe in range(20) if about(thing, posed, lobe)]
    assert near(thing, posed).tolist() == expected


def near(thing, posed):
    """The lobes about which a match looks right."""
    return lobes_about(thing.index, posed.camera_from_object)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_likeness_is_what_a_loop_counts(seed):
    """Keypoints that look right around a match, those aside that stand where the match stands.

    Its own edge, seen again.
    """
    thing, posed, data, rng = scene(seed)
    matches = np.where(rng.random(FEATURES) < 0.7, rng.permutation(18)[:FEATURES], -1)
    usual = clutter_density(thing.kb, data)
    right = by_loop(thing, posed, data, set(range(FEATURES)), data.described, AROUND)
    expected = []
    for feature, match in enumerate(matches.tolist()):
        how = {d: min(by.values()) for (f, d), by in right.items() if f == feature}
        apart, fit = how.get(match, (1.0, 1.0))
        others = [
            d
            for d, (off, _) in how.items()
            if np.linalg.norm(data.uv[d] - data.uv[match]) > SAME and off <= apart + AS_RIGHT
        ]
        by = right.get((feature, match))
        rare = as_right(thing, data, min(by, key=by.get), match, apart) if by else 1.0
        here = max(usual[match], data.types.count(data.types[match]) / (data.camera.width * data.camera.height))
        expected.append(1.0 if match < 0 else rarity(usual[match], len(others), apart, fit, rare, here))
    found = likeness(thing.index, posed, near(thing, posed), matches, data, thing.kb)
    assert found.tolist() == pytest.approx(expected, rel=1e-9)


def as_right(thing, data, lobe, match, apart):
    """Of the keypoints most like it in the image, the share that looks as right as the match, of the most known."""
    off = np.linalg.norm(thing.cloud.descriptor[lobe].astype(float) - data.descriptors, axis=1) / FARTHEST
    known = [d for d in range(len(off)) if off[d] < 1 and off[d] <= np.sort(off)[NTH - 1]]  # of equals all
    return min(
        1.0,
        sum(
            off[d] <= LOOSER * (apart + AS_RIGHT) and np.linalg.norm(data.uv[d] - data.uv[match]) >= SAME for d in known
        )
        / NTH,
    )


def rarity(usual, others, apart, fit, rare=0.0, here=0.0):
    """How much rarer what looks as right is than clutter of the word."""
    chance = BY_CHANCE * max(POWER * apart ** (POWER - 1), rare, RAREST)
    return fit * usual / (others / (pi * AROUND**2) + chance * max(usual, here))


@pytest.mark.parametrize(
    ("apart", "counts"),
    [(0.0, False), (SAME - 1.0, False), (SAME + 1.0, True), (AROUND - 1.0, True), (AROUND + 1.0, False)],
)
def test_the_same_edge_seen_again_is_no_clutter(apart, counts):
    thing, pose = ready(one_sided(1, 10)), pose_before(np.random.default_rng(5))
    rows = [keypoint_of(thing.cloud, lobe, pose, number=i) for i, lobe in enumerate([*range(10), 0])]
    data = data_of(rows, gamma_at(thing.cloud, [0], pose).camera)
    posed = pose_of(thing.index, pose, data, thing.kb)
    data.uv[10] = data.uv[0] + [0.6 * apart, 0.8 * apart]
    matches = np.arange(10)
    usual = clutter_density(thing.kb, data)[0]
    exact = against_even(0, TURNS, ANGLES) * against_even(0, GROWTH, SIZES)
    found = likeness(thing.index, posed, near(thing, posed), matches, data, thing.kb)[0]
    here = data.types.count(data.types[0]) / (data.camera.width * data.camera.height)
    rare = (apart >= SAME) / NTH  # wherever it is in the image
    assert found == pytest.approx(rarity(usual, counts, 0.0, exact, rare, here), rel=1e-9)


def test_the_more_a_match_looks_right_the_rarer_it_is():
    """Descriptors farther apart, an angle or a size that is off: each makes a match say less."""
    thing, pose = ready(one_sided(1, 10)), pose_before(np.random.default_rng(5))
    rows = [keypoint_of(thing.cloud, lobe, pose, number=lobe) for lobe in range(10)]
    said = []
    for change in (
        {},
        {"descriptors": 7},
        {"descriptors": 15},
        {"angle": 0.2},
        {"angle": 0.4},
        {"scale": 1.15},
        {"scale": 1.4},
    ):
        data = data_of(rows, gamma_at(thing.cloud, [0], pose).camera)
        data = replace(
            data,
            descriptors=np.clip(data.descriptors.astype(int) + change.get("descriptors", 0), 0, 255).astype(np.uint8),
            angle=data.angle + change.get("angle", 0.0),
            scale=data.scale * change.get("scale", 1.0),
        )
        posed = pose_of(thing.index, pose, data, thing.kb)
        said.append(likeness(thing.index, posed, near(thing, posed), np.arange(10), data, thing.kb)[0])
    assert said[0] >= said[1] > said[2]
    assert said[0] > said[3] > said[4]
    assert said[0] > said[5] > said[6]


def test_what_is_not_matched_is_one_and_so_is_all_where_nothing_is():
    thing, posed, data, _ = scene(3)
    assert (
        likeness(thing.index, posed, near(thing, posed), np.full(FEATURES, -1), data, thing.kb).tolist()
        == [1.0] * FEATURES
    )
    nothing = data.only(np.zeros(18, bool))
    assert (
        likeness(thing.index, posed, near(thing, posed), np.full(FEATURES, -1), nothing, thing.kb).tolist()
        == [1.0] * FEATURES
    )
    found = right_pairs(thing.index, posed, nothing, near(thing, posed), np.arange(FEATURES), nothing.described, AROUND)
    assert [len(part) for part in (found.feature, found.datum, found.pair, found.lobe)] == [0, 0, 0, 0]
