"""One keypoint is a whole pose: exactly the true one where the viewpoint lies on the axis of its lobe."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, gamma_at, keypoint_of, pose_on_axis, ready
from random_cloud import random_cloud

from geometry.frames import is_rigid
from plogic.match.gamma.data import data_of
from plogic.match.learned.keypoints import FARTHEST_MIDDLE, NEAREST_MIDDLE, Pairs, plausible, single_poses


def pairs(lobes):
    return Pairs(np.arange(len(lobes)), np.asarray(lobes, np.intp), np.ones(len(lobes)))


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(0, 10), st.floats(0.5, 3.0))
def test_a_keypoint_gives_back_the_pose_it_was_seen_from(seed, lobe, distance):
    thing, rng = ready(random_cloud(seed)), np.random.default_rng(seed)
    pose = pose_on_axis(rng, thing.cloud, lobe, distance)
    found = single_poses(thing.index, pairs([lobe]), gamma_at(thing.cloud, [lobe], pose))
    assert found.shape == (1, 4, 4)
    assert is_rigid(found[0])
    np.testing.assert_allclose(found[0], pose, atol=1e-5)  # undistorting is iterative


def test_several_keypoints_are_as_each_alone():
    thing, rng = ready(), np.random.default_rng(4)
    lobes = [3, 0, 7, 3]
    poses = [pose_on_axis(rng, thing.cloud, lobe, 1.0) for lobe in lobes]
    rows = [
        keypoint_of(thing.cloud, lobe, pose, number=i) for i, (lobe, pose) in enumerate(zip(lobes, poses, strict=True))
    ]
    np.testing.assert_allclose(single_poses(thing.index, pairs(lobes), data_of(rows, CAMERA)), poses, atol=1e-5)


@pytest.mark.parametrize(
    ("factor", "kept"), [(0.9 * NEAREST_MIDDLE, 0), (1.5, 1), (0.9 * FARTHEST_MIDDLE, 1), (1.1 * FARTHEST_MIDDLE, 0)]
)
def test_what_is_too_near_or_too_far_is_not_believed(factor, kept):
    thing = ready()
    pose = np.eye(4)
    pose[:3, 3] = np.array([0, 0, factor * thing.index.diameter]) - thing.index.centre
    assert plausible(thing.index, pose[None]).tolist() == [bool(kept)]
    assert not plausible(thing.index, np.full((1, 4, 4), np.nan)).any()
