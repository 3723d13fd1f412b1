"""What looks right at a pose, by a loop over all features, appearances and keypoints; and how rare that is where it is."""

from __future__ import annotations

from dataclasses import replace
from math import acos, log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learnt_scenes import gamma_at, keypoint_of, one_sided, pose_before, ready, viewpoint
from random_cloud import random_cloud

from plogic.evidence import clutter_density
from plogic.search.data import data_of
from plogic.search.learnt.agreement import ANGLES, ASIDE, GRAZING, SIZES, screen_angle
from plogic.search.learnt.lexicon import FARTHEST
from plogic.search.learnt.looks import AROUND, BY_CHANCE, LOOSER, SAME, likeness, lobes_about, right_pairs
from plogic.search.learnt.settle import pose_of

FEATURES = 8


def scene(seed):
    """A type of which appearances look alike, at a pose, among keypoints of it that are anywhere near."""
    rng = np.random.default_rng(seed)
    look = np.clip(rng.integers(0, 256, 128) + rng.normal(0, 14, (20, 128)), 0, 255).astype(np.uint8)
    cloud = random_cloud(seed, FEATURES, 20, descriptor=look, half_angle=rng.uniform(0.2, 1.5, 20), size=np.full(20, 0.015))
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


def looks_right(thing, posed, data, lobe, datum):
    cloud, at = thing.cloud, posed.at[thing.cloud.feature[lobe]]
    if abs(log(cloud.size[lobe] * data.camera.f / at[2] / data.scale[datum])) >= SIZES:
        return False
    turned = float(screen_angle(posed.camera_from_object[:3, :3] @ cloud.up[lobe], at)) - data.angle[datum]
    apart = np.linalg.norm(cloud.descriptor[lobe].astype(float) - data.descriptors[datum])
    return abs((turned + pi) % (2 * pi) - pi) < ANGLES and apart < LOOSER * FARTHEST[128]


def by_loop(thing, posed, data, features, free, reach):
    """{(feature, datum): the lobes by which it looks right}."""
    found = {}
    for lobe in range(len(thing.cloud.feature)):
        feature = int(thing.cloud.feature[lobe])
        if feature not in features or not about(thing, posed, lobe):
            continue
        for datum in np.flatnonzero(free):
            near = np.linalg.norm(data.uv[datum] - posed.uv[feature]) <= reach
            if near and looks_right(thing, posed, data, lobe, datum):
                found.setdefault((feature, int(datum)), set()).add(lobe)
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
    assert ways == expected
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
    """Keypoints that look right around a match, those aside that stand where the match stands: its own edge, seen again."""
    thing, posed, data, rng = scene(seed)
    matches = np.where(rng.random(FEATURES) < 0.7, rng.permutation(18)[:FEATURES], -1)
    usual = clutter_density(thing.kb, data)
    right = by_loop(thing, posed, data, set(range(FEATURES)), data.described, AROUND)
    expected = []
    for feature, match in enumerate(matches.tolist()):
        others = [d for f, d in right if f == feature and np.linalg.norm(data.uv[d] - data.uv[match]) > SAME]
        expected.append(1.0 if match < 0 else usual[match] / (len(others) / (pi * AROUND**2) + BY_CHANCE * usual[match]))
    assert likeness(thing.index, posed, near(thing, posed), matches, data, thing.kb).tolist() == pytest.approx(expected)


@pytest.mark.parametrize(("apart", "counts"), [(0.0, False), (SAME - 1.0, False), (SAME + 1.0, True), (AROUND - 1.0, True), (AROUND + 1.0, False)])
def test_the_same_edge_seen_again_is_no_clutter(apart, counts):
    thing, pose = ready(one_sided(1, 10)), pose_before(np.random.default_rng(5))
    rows = [keypoint_of(thing.cloud, lobe, pose, number=i) for i, lobe in enumerate([*range(10), 0])]
    data = data_of(rows, gamma_at(thing.cloud, [0], pose).camera)
    posed = pose_of(thing.index, pose, data, thing.kb)
    data.uv[10] = data.uv[0] + [0.6 * apart, 0.8 * apart]
    matches = np.arange(10)
    usual = clutter_density(thing.kb, data)[0]
    others = counts / (pi * AROUND**2)
    assert likeness(thing.index, posed, near(thing, posed), matches, data, thing.kb)[0] == pytest.approx(usual / (others + BY_CHANCE * usual))


def test_what_is_not_matched_is_one_and_so_is_all_where_nothing_is():
    thing, posed, data, _ = scene(3)
    assert likeness(thing.index, posed, near(thing, posed), np.full(FEATURES, -1), data, thing.kb).tolist() == [1.0] * FEATURES
    nothing = data.only(np.zeros(18, bool))
    assert likeness(thing.index, posed, near(thing, posed), np.full(FEATURES, -1), nothing, thing.kb).tolist() == [1.0] * FEATURES
    found = right_pairs(thing.index, posed, nothing, near(thing, posed), np.arange(FEATURES), nothing.described, AROUND)
    assert [len(part) for part in (found.feature, found.datum, found.pair, found.lobe)] == [0, 0, 0, 0]
