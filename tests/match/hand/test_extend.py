"""From coarse poses to refined ones: matching, and least squares (§6.3)."""

import numpy as np
import pytest
from synthetic import CAMERA, camera_pose, is_right, perceiver, scene

from geometry.frames import from_rotation_translation, is_rigid, rotation_from_quat_xyzw, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.hand.distance_maps import distance_maps
from plogic.match.hand.extend import Candidates, extend, firsts, nearest, rigid, shown
from plogic.match.hand.place_index import place_index

TOLERANCE = 3.0


def view(name, seed):
    index, rng = perceiver().models[name], np.random.default_rng(seed)
    pose = camera_pose(rng, (3.0, 5.0))
    data = data_of(scene(rng, {name: pose}, clutter=8).gamma.appearances, CAMERA)
    places = place_index([index])
    return places, pose, data, distance_maps(places.allowed(data), data), rng


def extended(places, starts, maps, data):
    count = len(starts)
    start = Candidates(np.zeros(count, int), starts, np.zeros((count, 0), int), np.zeros(count))
    return extend(places, start, maps, data, TOLERANCE)


def centre_of(places):
    return places.centres[0]


def perturbed(rng, pose, centre, degrees, share):
    """The pose turned about the object's centre by some degrees about any axis, and moved by that share of distance."""
    axis = rng.normal(size=3)
    half = np.radians(degrees) / 2
    turned = rotation_from_quat_xyzw([*(np.sin(half) * axis / np.linalg.norm(axis)), np.cos(half)])
    moved = pose @ from_rotation_translation(turned, centre - turned @ centre)
    step = rng.normal(size=3)
    moved[:3, 3] += share * np.linalg.norm(pose[:3, 3]) * step / np.linalg.norm(step)
    return moved


@pytest.mark.parametrize("name", ["t1", "t2"])
@pytest.mark.parametrize("seed", range(5040, 5044))
def test_the_true_pose_is_recovered_from_perturbed_ones(name, seed):
    """8° and 2 % of the distance is a cell's width off.

    Those that come home come first.
    """
    places, pose, data, maps, rng = view(name, seed)
    starts = np.stack([perturbed(rng, pose, centre_of(places), 8.0, 0.02) for _ in range(8)])
    found = extended(places, starts, maps, data)
    right = [is_right(name, p, pose) for p in found.poses]
    assert right[0]
    assert sum(right) >= 0.75 * len(right)
    assert np.isfinite(found.worth[0])
    used = found.matches[0] >= 0
    off = CAMERA.project(transform_points(found.poses[0], places.points[0][used])) - data.uv[found.matches[0][used]]
    assert np.sqrt((off**2).sum(axis=1).mean()) < 1.5


def test_a_batch_equals_singles():
    """No candidate's result depends on its company."""
    places, pose, data, maps, rng = view("t1", 5044)
    starts = np.stack([perturbed(rng, pose, centre_of(places), 6.0, 0.02) for _ in range(5)])
    batch = extended(places, starts, maps, data).poses
    alone = [extended(places, s[None], maps, data).poses for s in starts]
    singles = np.concatenate(alone)
    assert (len(batch), len(singles)) == (2, 5), "the best go on"
    apart = np.abs(batch[:, None] - singles[None]).max(axis=(2, 3))
    assert apart.min(axis=1).max() < 2e-3, "each has its like among the singles"


def test_poses_stay_rigid():
    places, pose, data, maps, rng = view("t2", 5045)
    starts = np.stack([perturbed(rng, pose, centre_of(places), 20.0, 0.05) for _ in range(10)])
    found = extended(places, starts, maps, data)
    assert len(found.poses) > 0
    assert all(is_rigid(p) for p in found.poses)


def test_the_nearest_rigid_motion_of_a_rigid_motion_is_itself():
    rng = np.random.default_rng(3)
    poses = np.stack([camera_pose(rng) for _ in range(5)])
    assert np.allclose(rigid(poses), poses)
    assert np.allclose(rigid(poses + 1e-4 * rng.normal(size=poses.shape)[:, :1]), poses, atol=1e-3)


def test_a_datum_serves_one_feature_and_lies_within_the_tolerance():
    places, pose, data, maps, rng = view("t1", 5046)
    starts = np.stack([pose, *(perturbed(rng, pose, centre_of(places), 5.0, 0.02) for _ in range(10))])
    matches = nearest(shown(places, np.zeros(11, int), starts, data), maps, np.full(11, 12.0))
    assert len(matches) == 11
    for start, row in zip(starts, matches, strict=True):
        used = row[row >= 0]
        assert len(used) >= 4
        assert len(set(used.tolist())) == len(used)
        at = places.points[0] @ start[:3, :3].T + start[:3, 3]
        off = np.linalg.norm(CAMERA.project(at)[row >= 0] - data.uv[used], axis=1)
        assert (off <= 12.0 + 1.5).all(), "maps are to a pixel"


def test_a_zero_tolerance_matches_nothing_but_what_coincides():
    places, pose, data, maps, _ = view("t1", 5047)
    assert (nearest(shown(places, np.zeros(1, int), pose[None], data), maps, np.array([-1.0])) == -1).all()


def test_one_pose_can_be_taken():
    places, pose, data, maps, _ = view("t2", 5048)
    found = extended(places, np.stack([pose] * 5), maps, data)
    assert found.take(np.array([1])).poses.shape == (1, 4, 4)


def test_what_is_used_comes_first_and_no_row_is_longer_than_the_fullest():
    rng = np.random.default_rng(6)
    used = rng.random((30, 12)) < 0.4
    columns = firsts(used)
    assert columns.shape == (30, used.sum(axis=1).max())
    for row, mine in zip(used, columns, strict=True):
        assert mine[: row.sum()].tolist() == np.flatnonzero(row).tolist()
        assert not row[mine[row.sum() :]].any()
