"""Sides of edges as features of a cloud: where they are, which way they face, how often they were seen.

And clouds with and without them.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_sides import COLOURS, CONTRAST, COUNT, DIAMETER, F_REF, PIXEL, an_edge, keypoints, some_of, towards
from random_cloud import random_cloud

from geometry.cones import even_directions, spacing
from kb.clouds.learned import LearnedCloud, cloud_bytes, read_cloud
from kb.learning.again import LOOKS, STRETCH, VARIED, WIDE
from kb.learning.features import BEYOND, LEAST_SEEN, MOST_SIDES, SIDES_SEEN, cloud_of
from kb.learning.observations import joined

SEEDS = st.integers(0, 9999)
REACH = 0.4 * STRETCH * DIAMETER
"""Metres to both sides of an edge's middle that are surely one stretch."""
NEAR = 15.0
"""Degrees about an axis within which directions are surely of one lobe."""
ABOVE = towards((0.0, 0.0, 1.0), NEAR)


def cloud(seen, count=COUNT):
    return cloud_of(seen, DIAMETER, F_REF, count)


def same(one, other):
    for f in fields(LearnedCloud):
        np.testing.assert_allclose(getattr(one, f.name), getattr(other, f.name), rtol=1e-9, atol=1e-12, err_msg=f.name)


def facing(here):
    """(L, 3) what of +y is perpendicular to each lobe's axis."""
    up = np.array([0.0, 1.0, 0.0]) - here.axis[:, 1:2] * here.axis
    return up / np.linalg.norm(up, axis=1, keepdims=True)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 6), st.floats(0.0, REACH), st.floats(0.0, 0.1))
def test_a_stretch_of_an_edge_is_one_feature_that_faces_its_side(seed, times, along, share):
    across = share * WIDE * DIAMETER
    seen = an_edge(np.random.default_rng(seed), ABOVE, times, along=along, across=across, middle=(0.01, 0.02, 0.03))
    here = cloud(seen)
    assert len(here.at) == len(here.feature) == 1
    assert here.sided.all()
    assert (here.size == 0).all()
    assert np.abs(here.at - seen.at.mean(axis=0)).max() < 1e-12
    assert (here.up * facing(here)).sum(axis=1) == pytest.approx(1.0, abs=0.01)
    assert np.abs((here.up * here.axis).sum(axis=1)).max() < 1e-12
    np.testing.assert_allclose(here.normal, [[0, 0, 1]], atol=1e-12)
    assert here.descriptor[0].tolist() == [0] * 128 + [*COLOURS, CONTRAST] + [0] * 5


@settings(max_examples=30, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, REACH), st.floats(0.0, 0.15))
def test_how_exact_it_is_is_told_across_the_edge_alone(seed, along, share):
    """From directions in the plane across y every side faces +y; so what is along x counts nothing."""
    rng, across = np.random.default_rng(seed), share * WIDE * DIAMETER
    seen = an_edge(rng, ABOVE, 4, along=along, across=across)
    seen = replace(seen, up=np.tile([0.0, 1.0, 0.0], (len(seen), 1)), hit=rng.uniform(0.5, 1.0, len(seen)))
    here = cloud(seen)
    middle = (seen.hit * seen.at[:, 1]).sum() / seen.hit.sum()
    expected = max(float(np.sqrt(((seen.at[:, 1] - middle) ** 2).mean())), 0.3 * PIXEL)
    assert here.sigma == pytest.approx([expected])


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    SEEDS, st.integers(2, 6), st.floats(0.0, REACH), st.lists(st.integers(0, 3), min_size=1, max_size=3, unique=True)
)
def test_a_picture_that_shows_many_points_of_a_stretch_counts_once(seed, times, along, levels):
    once = an_edge(np.random.default_rng(seed), ABOVE, along=along, levels=levels)
    hit = np.random.default_rng(seed).uniform(0.5, 1.0, len(once))
    once = replace(once, hit=hit)
    often = joined([once, *(replace(once, at=np.roll(once.at, k, axis=0), hit=hit * 0.99) for k in range(1, times))])
    one, other = cloud(once), cloud(often)
    assert len(one.hit) == len(other.hit) == 1
    assert other.hit == pytest.approx(one.hit)
    assert other.axis == pytest.approx(one.axis)
    assert other.half_angle == pytest.approx(one.half_angle)


def rate(seen):
    """By hand: how often each of the pictures from within the lobe shows any; they number at least its mean count."""
    axis = seen.direction.mean(axis=0) / np.linalg.norm(seen.direction.mean(axis=0))
    half = float(np.arccos((seen.direction @ axis).min())) + BEYOND * spacing(COUNT)
    best = {}
    for picture, hit in zip(zip(seen.view.tolist(), seen.level.tolist(), strict=True), seen.hit.tolist(), strict=True):
        best[picture] = max(best.get(picture, 0.0), hit)
    could = max(sum(d @ axis >= np.cos(half) for d in even_directions(COUNT)), COUNT * (1 - np.cos(half)) / 2)
    return min(1.0, sum(best.values()) / (could * (np.ptp(seen.level) + 1)))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    SEEDS,
    st.integers(1, 4),
    st.floats(0.0, 6.3),
    st.sampled_from([(0,), (1, 2), (1, 2, 3), (0, 2)]),
    st.floats(0.4, 1.0),
)
def test_a_hit_rate_is_the_share_of_the_pictures_of_its_lobe_that_showed_it(seed, times, turn, levels, share):
    """What has less than ``SIDES_SEEN`` of them is no feature."""
    rng = np.random.default_rng(seed)
    seen = an_edge(rng, towards((np.cos(turn), 0.0, np.sin(turn)), NEAR), times, along=REACH, levels=levels)
    seen = some_of(seen, np.sort(rng.permutation(len(seen))[: max(LEAST_SEEN, round(share * len(seen)))]))
    seen = replace(seen, hit=rng.uniform(0.5, 1.0, len(seen)))
    expected = rate(seen)
    assert cloud(seen).hit.tolist() == (pytest.approx([expected]) if expected >= SIDES_SEEN else [])


def test_what_is_seldom_seen_is_no_feature():
    """Three pictures of all sizes, of all that a lobe about them holds."""
    seen = an_edge(np.random.default_rng(0), ABOVE, levels=range(4))
    few = some_of(seen, [0, len(ABOVE) // 2, len(seen) - 1])
    assert len(few) == LEAST_SEEN
    assert len(cloud(few).at) == 0
    assert len(cloud(some_of(seen, np.arange(LEAST_SEEN - 1))).at) == 0
    assert len(cloud(seen).at) == 1


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.integers(2, 5))
def test_edges_apart_and_the_two_sides_of_one_are_features_of_their_own(seed, count):
    rng = np.random.default_rng(seed)
    middles = np.column_stack([np.zeros(count), 0.05 * np.arange(count), np.zeros(count)])
    edges = [an_edge(rng, ABOVE, 2, along=REACH, middle=middle) for middle in middles]
    edges += [replace(edge, up=-edge.up) for edge in edges]
    here = cloud(joined(edges))
    assert len(here.at) == 2 * count
    assert sorted(np.round(here.at[:, 1] / 0.05).astype(int).tolist()) == sorted([*range(count), *range(count)])
    ways = np.sign((here.up * facing(here)).sum(axis=1))[np.unique(here.feature, return_index=True)[1]]
    assert ways.sum() == 0


def test_another_colour_from_elsewhere_is_another_lobe_of_the_same_feature():
    left, right = ABOVE[even_directions(COUNT)[ABOVE, 0] < 0], ABOVE[even_directions(COUNT)[ABOVE, 0] >= 0]
    rng, other = np.random.default_rng(0), (150, 100, 150, 100)
    here = cloud(joined([an_edge(rng, left, 2, along=REACH), an_edge(rng, right, 2, along=REACH, colours=other)]))
    assert len(here.at) == 1
    assert sorted(here.descriptor[:, LOOKS].tolist()) == sorted([[*COLOURS, CONTRAST], [*other, CONTRAST]])


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.0, 400.0), st.integers(1, 3))
def test_how_much_the_contrast_varied_is_told_in_whole_bytes(seed, spread, times):
    rng = np.random.default_rng(seed)
    seen = an_edge(rng, ABOVE, times)
    contrast = 128.0 + spread * np.where(np.arange(len(seen)) % 2, 1.0, -1.0)
    seen.descriptor[:, LOOKS.stop - 1] = contrast
    here = cloud(seen)
    assert len(here.feature) == 1  # looks as different as can be are one lobe: contrast tells no lobes apart
    assert here.descriptor[0, VARIED] == pytest.approx(min(contrast.std(), 255.0), abs=0.51)
    assert here.descriptor[0, LOOKS.stop - 1] == pytest.approx(contrast.mean(), abs=0.51)
    assert here.descriptor[0, VARIED + 1 :].tolist() == [0] * 4


def test_of_keypoints_the_byte_is_as_any_other():
    here = cloud(keypoints(np.random.default_rng(3), ABOVE, 3))
    seen = keypoints(np.random.default_rng(3), ABOVE, 3)
    assert sorted(here.descriptor[:, VARIED].tolist()) == sorted(set(seen.descriptor[:, VARIED].astype(int).tolist()))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 5), st.integers(1, 3))
def test_sides_leave_keypoints_as_they_are_and_keypoints_sides(seed, places, edges):
    rng = np.random.default_rng(seed)
    points = keypoints(rng, ABOVE, places)
    sides = joined([an_edge(rng, ABOVE, 2, along=REACH, middle=(0.0, 0.05 * k, 0.0)) for k in range(edges)])
    whole = joined([points, sides])
    both = cloud(some_of(whole, rng.permutation(len(whole))))
    apart = cloud(points)
    assert both.sided.sum() == len(cloud(sides).feature) > 0
    assert len(both.keypoints.at) == len(apart.at) > 0
    order = [int(np.linalg.norm(apart.at - at, axis=1).argmin()) for at in both.keypoints.at]
    assert sorted(order) == list(range(len(apart.at)))
    for name in ("at", "sigma", "normal"):
        np.testing.assert_allclose(getattr(both.keypoints, name), getattr(apart, name)[order], atol=1e-9)
    same(cloud(whole).keypoints, apart)


def test_of_many_stretches_the_most_are_kept(monkeypatch):
    seen = joined([an_edge(np.random.default_rng(k), ABOVE, middle=(0.0, 0.05 * k, 0.0)) for k in range(9)])
    assert MOST_SIDES > 9
    assert len(cloud(seen).at) == 9
    monkeypatch.setattr("kb.learning.features.MOST_SIDES", 4)
    assert len(cloud(seen).at) == 4


def test_a_cloud_of_sides_can_be_read_again():
    rng = np.random.default_rng(1)
    here = cloud(joined([keypoints(rng, ABOVE), an_edge(rng, ABOVE, 3, along=REACH, levels=(1, 2))]))
    back = read_cloud(cloud_bytes(here))
    assert back.sided.tolist() == here.sided.tolist()
    assert 0 < back.sided.sum() < len(back.sided)
    assert cloud_bytes(back) == cloud_bytes(here)


def mixed(seed, features, more, choice, **changed):
    """A random cloud, of whose lobes those of ``choice`` are sides."""
    count = features + more if features else 0
    plain = random_cloud(seed, features, count, width=138)
    sided = np.resize(np.array(choice, bool), count)
    return replace(plain, size=np.where(sided, 0.0, plain.size), **changed)


MIXED = (SEEDS, st.integers(0, 8), st.integers(0, 9), st.lists(st.booleans(), min_size=1, max_size=17))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(*MIXED)
def test_without_its_sides_a_cloud_has_exactly_the_other_lobes_and_their_features(seed, features, more, choice):
    here = mixed(seed, features, more, choice, part=np.arange(features) + 1)
    rest, kept = here.keypoints, np.flatnonzero(here.size > 0)
    assert here.sided.tolist() == [size == 0 for size in here.size]
    assert len(rest.feature) == len(kept)
    assert sorted(set(rest.feature.tolist())) == list(range(len(rest.at)))
    for name in ("lobe_word", "descriptor", "axis", "half_angle", "r_min", "r_max", "hit", "up", "size"):
        assert np.array_equal(getattr(rest, name), getattr(here, name)[kept]), name
    for name in ("at", "sigma", "normal", "word", "part"):
        assert np.array_equal(getattr(rest, name)[rest.feature], getattr(here, name)[here.feature[kept]]), name
    assert not rest.sided.any()
    same(rest.keypoints, rest)
    assert len(read_cloud(cloud_bytes(rest)).feature) == len(kept)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(*MIXED)
def test_a_cloud_with_sides_comes_back_and_is_the_same_bytes_again(seed, features, more, choice):
    here = mixed(seed, features, more, choice)
    back = read_cloud(cloud_bytes(here))
    assert back.sided.tolist() == here.sided.tolist()
    assert cloud_bytes(back) == cloud_bytes(here)
    assert cloud_bytes(back.keypoints) == cloud_bytes(here.keypoints)


def test_a_cloud_without_sides_is_its_own_keypoints():
    assert cloud_bytes(random_cloud(width=138).keypoints) == cloud_bytes(random_cloud(width=138))
