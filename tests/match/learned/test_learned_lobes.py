"""Which lobes hold many viewpoints at once, in single precision, against the definition (§2.7) in double."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import one_sided, pose_before, ready, viewpoint, with_sides
from random_cloud import random_cloud, unit

from plogic.match.learned import agreement as lobes_module
from plogic.match.learned.agreement import ASIDE, GRAZING, first_held, held_from, lobes_about

SEEDS = st.integers(0, 9999)
RIM = 1e-4
"""Radians, and the share of a distance, within which either answer will do."""


def made(seed, features=12, lobes=40, middle=(0.0, 0.0, 0.0)):
    rng = np.random.default_rng(seed)
    at = np.asarray(middle) + rng.uniform(-0.1, 0.1, (features, 3))
    return ready(random_cloud(seed, features, lobes, at=at, half_angle=rng.uniform(0.05, 2.5, lobes)))


def seen(cloud, viewpoints):
    """(H, L) radians from each lobe's axis, and metres, in double precision."""
    line = viewpoints[:, None] - cloud.at[cloud.feature][None]
    away = np.linalg.norm(line, axis=2)
    return np.arccos(np.clip(np.einsum("hli,li->hl", line, cloud.axis) / away, -1.0, 1.0)), away


def around(rng, count, middle=(0.0, 0.0, 0.0)):
    return np.asarray(middle) + unit(rng.normal(size=(count, 3))) * rng.uniform(0.15, 4.0, (count, 1))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    SEEDS,
    st.integers(1, 30),
    st.floats(0.3, 3.0),
    st.sampled_from([(0.0, 0.0, 0.0), (0.4, -0.3, 0.2), (30.0, 20.0, -10.0)]),
)
def test_lobes_hold_the_viewpoints_that_are_within_their_cone_and_range(seed, count, granularity, middle):
    """Also where the object's frame lies far away from it."""
    thing, viewpoints = made(seed, middle=middle), around(np.random.default_rng(seed), count, middle)
    cloud, (angle, away) = thing.cloud, seen(thing.cloud, viewpoints)
    near, far = cloud.r_min * granularity, cloud.r_max * granularity
    expected = (angle <= cloud.half_angle) & (away >= near) & (away <= far)
    rim = np.minimum(np.abs(angle - cloud.half_angle), np.minimum(np.abs(away / near - 1.0), np.abs(away / far - 1.0)))
    found = held_from(thing.index.lobes, viewpoints, granularity)
    assert found.shape == (count, len(cloud.feature))
    assert found.dtype == bool
    assert (found == expected)[rim > RIM].all()
    assert (rim > RIM).mean() > 0.9
    assert held_from(thing.index.lobes, viewpoints[:0], granularity).shape == (0, len(cloud.feature))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, 30), st.integers(1, 45), st.integers(1, 60), st.floats(0.3, 3.0))
def test_the_first_that_hold_are_those_of_all_that_hold(seed, count, most, block, granularity):
    lobes, viewpoints = made(seed).index.lobes, around(np.random.default_rng(seed), count)
    all_held = held_from(lobes, viewpoints, granularity)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lobes_module, "_LOBES_BLOCK", block)
        viewpoint, place = first_held(lobes, viewpoints, granularity, most)
    expected = [(h, p) for h in range(count) for p in np.flatnonzero(all_held[h])[:most].tolist()]
    assert list(zip(viewpoint.tolist(), place.tolist(), strict=True)) == expected


def test_both_answers_are_given():
    thing = made(0)
    share = held_from(thing.index.lobes, around(np.random.default_rng(0), 200), 1.0).mean()
    assert 0.1 < share < 0.9


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.floats(0.2, 4.0), st.floats(0.0, 3.0))
def test_about_a_pose_are_the_lobes_of_keypoints_that_a_little_more_width_would_make_hold_it(seed, distance, tilt):
    """From however far."""
    rng = np.random.default_rng(seed)
    cloud = with_sides(random_cloud(seed, 12, 40, width=138, half_angle=rng.uniform(0.05, 2.5, 40)), [2, 3, 7])
    thing, pose = ready(cloud), pose_before(rng, distance, tilt)
    angle = seen(cloud, viewpoint(pose)[None])[0][0]
    wide = np.minimum(cloud.half_angle + ASIDE, GRAZING)
    found = np.isin(np.arange(40), lobes_about(thing.index, pose))
    assert (found == ((angle <= wide) & ~cloud.sided))[np.abs(angle - wide) > RIM].all()
    assert not found[cloud.sided].any()
    assert 0 < cloud.sided.sum() < 40


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 9))
def test_each_viewpoint_is_asked_for_itself(seed, count):
    thing, viewpoints = made(seed), around(np.random.default_rng(seed), count)
    angle, away = seen(thing.cloud, viewpoints)
    inner = (
        (np.abs(angle - thing.cloud.half_angle) > RIM)
        & (np.abs(away - thing.cloud.r_min) > RIM)
        & (np.abs(away - thing.cloud.r_max) > RIM)
    )
    alone = np.concatenate([held_from(thing.index.lobes, one[None], 1.0) for one in viewpoints])
    assert (held_from(thing.index.lobes, viewpoints, 1.0) == alone)[inner].all()


def test_what_is_seen_in_front_is_seen_by_all_of_one_side():
    thing = ready(one_sided(3, 24))
    assert held_from(thing.index.lobes, np.array([[0.0, 0, 1.0], [0.0, 0, -1.0]]), 1.0).tolist() == [
        [True] * 24,
        [False] * 24,
    ]
