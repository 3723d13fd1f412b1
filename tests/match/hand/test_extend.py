"""From coarse poses to refined ones: matching, sets of four, POSIT, least squares (§6.1, §6.3)."""

import numpy as np
import pytest
from synthetic import CAMERA, camera_pose, is_right, perceiver, scene

from geometry.frames import from_rotation_translation, is_rigid, rotation_from_quat_xyzw, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.hand.extend import extend, firsts, rematch, rigid
from plogic.match.hand.view_cells import distance_maps

TOLERANCE = 3.0


def view(name, seed):
    index, rng = perceiver().models[name], np.random.default_rng(seed)
    pose = camera_pose(rng, (3.0, 5.0))
    data = data_of(scene(rng, {name: pose}, clutter=8).gamma.appearances, CAMERA)
    return index, pose, data, distance_maps(index.allowed(data), data), rng


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

    Half of the starts come home, and the first of the result is right.
    """
    index, pose, data, maps, rng = view(name, seed)
    starts = np.stack([perturbed(rng, pose, index.cells.centre, 8.0, 0.02) for _ in range(8)])
    found = extend(starts, index.cells, index.points, index.weights, maps, data, TOLERANCE)
    right = [is_right(name, p, pose) for p in found.camera_from_object]
    assert right[0]
    assert sum(right) >= 4
    assert found.fitted[0]
    used = found.matches[0] >= 0
    off = (
        CAMERA.project(transform_points(found.camera_from_object[0], index.points[used]))
        - data.uv[found.matches[0][used]]
    )
    assert np.sqrt((off**2).sum(axis=1).mean()) < 1.5


def test_a_batch_equals_singles():
    """No candidate's result depends on its company."""
    index, pose, data, maps, rng = view("t1", 5044)
    starts = np.stack([perturbed(rng, pose, index.cells.centre, 6.0, 0.02) for _ in range(5)])
    batch = extend(starts, index.cells, index.points, index.weights, maps, data, TOLERANCE).camera_from_object
    alone = [
        extend(s[None], index.cells, index.points, index.weights, maps, data, TOLERANCE).camera_from_object
        for s in starts
    ]
    singles = np.concatenate(alone)
    assert len(batch) == len(singles) >= 5
    apart = np.abs(batch[:, None] - singles[None]).max(axis=(2, 3))
    assert apart.min(axis=0).max() < 2e-3, "every single has its like in the batch"
    assert apart.min(axis=1).max() < 2e-3, "and the other way round"


def test_poses_stay_rigid():
    index, pose, data, maps, rng = view("t2", 5045)
    starts = np.stack([perturbed(rng, pose, index.cells.centre, 20.0, 0.05) for _ in range(10)])
    found = extend(starts, index.cells, index.points, index.weights, maps, data, TOLERANCE)
    assert len(found.camera_from_object) > 0
    assert all(is_rigid(p) for p in found.camera_from_object)


def test_the_nearest_rigid_motion_of_a_rigid_motion_is_itself():
    rng = np.random.default_rng(3)
    poses = np.stack([camera_pose(rng) for _ in range(5)])
    assert np.allclose(rigid(poses), poses)
    assert np.allclose(rigid(poses + 1e-4 * rng.normal(size=poses.shape)[:, :1]), poses, atol=1e-3)


def test_a_datum_serves_one_feature_and_lies_within_the_tolerance():
    index, pose, data, maps, rng = view("t1", 5046)
    starts = np.stack([pose, *(perturbed(rng, pose, index.cells.centre, 5.0, 0.02) for _ in range(10))])
    matches = rematch(starts, index.cells, index.points, maps, data, np.full(11, 12.0))
    assert len(matches) == 11
    for start, row in zip(starts, matches, strict=True):
        used = row[row >= 0]
        assert len(used) >= 4
        assert len(set(used.tolist())) == len(used)
        at = index.points @ start[:3, :3].T + start[:3, 3]
        off = np.linalg.norm(CAMERA.project(at)[row >= 0] - data.uv[used], axis=1)
        assert (off <= 12.0 + 1.5).all(), "maps are to a pixel"


def test_a_zero_tolerance_matches_nothing_but_what_coincides():
    index, pose, data, maps, _ = view("t1", 5047)
    assert (rematch(pose[None], index.cells, index.points, maps, data, np.array([-1.0])) == -1).all()


def test_one_pose_can_be_taken():
    index, pose, data, maps, _ = view("t2", 5048)
    found = extend(np.stack([pose, pose]), index.cells, index.points, index.weights, maps, data, TOLERANCE)
    assert found.take(np.array([1])).camera_from_object.shape == (1, 4, 4)


def test_what_is_used_comes_first_and_no_row_is_longer_than_the_fullest():
    rng = np.random.default_rng(6)
    used = rng.random((30, 12)) < 0.4
    columns = firsts(used)
    assert columns.shape == (30, used.sum(axis=1).max())
    for row, mine in zip(used, columns, strict=True):
        assert mine[: row.sum()].tolist() == np.flatnonzero(row).tolist()
        assert not row[mine[row.sum() :]].any()
