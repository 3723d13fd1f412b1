"""Where appearances carry depth: what is at another depth is not matched, and depths fix poses."""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.frames import from_rotation_translation, pose_error, rotation_from_quat_xyzw, transform_points
from geometry.poses.refine import Sight, refine_poses
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import side_sight, with_depths
from sensing.appearance import Appearance

CAMERA = Camera(640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]))
POINTS = np.random.default_rng(5).uniform(-0.05, 0.05, (12, 3))
TRUTH = from_rotation_translation(rotation_from_quat_xyzw([0.2, -0.1, 0.3, 0.9]), [0.1, -0.05, 2.0])


def seen(noise, spread, seed):
    """Data of a small object two metres away, with depths of such a standard deviation."""
    rng = np.random.default_rng(seed)
    at = transform_points(TRUTH, POINTS)
    uv, depth = CAMERA.project(at) + rng.normal(0.0, noise, (12, 2)), at[:, 2] + rng.normal(0.0, spread, 12)
    rows = zip(uv.tolist(), depth.tolist(), strict=True)
    data = [
        Appearance(f"a{i}", "t", tuple(place), "test", depth=d, depth_sigma=spread) for i, (place, d) in enumerate(rows)
    ]
    return data_of(data, CAMERA)


def alone(data):
    start = TRUTH @ from_rotation_translation(rotation_from_quat_xyzw([0.02, 0.02, 0.0, 1.0]), [0.01, 0.0, 0.02])
    return refine_poses(start[None], POINTS[None], data.uv[None], np.ones((1, 12)), CAMERA, 30)[0][0]


def test_depths_fix_how_far_away_it_is():
    off = []
    for seed in range(20):
        data = seen(1.0, 0.004, seed)
        pose = alone(data)
        sight = Sight(CAMERA, np.eye(4), POINTS, data.uv, np.ones(12))
        better = with_depths(pose, sight, np.arange(12), data, sigma=1.0, huber=3.0)
        off.append([abs(float(one[2, 3] - TRUTH[2, 3])) for one in (pose, better)])
    assert np.median(off, axis=0)[1] < 0.5 * np.median(off, axis=0)[0]


def test_the_unit_of_weights_changes_nothing():
    """Weights in any unit, as long as sigma is the noise that they stand for."""
    data = seen(1.0, 0.01, 3)
    poses = []
    for weight in (1.0, 4.0):
        sight = Sight(CAMERA, np.eye(4), POINTS, data.uv, np.full(12, weight))
        poses.append(with_depths(alone(data), sight, np.arange(12), data, sigma=1.0, huber=1e6))
    assert max(float(e) for e in pose_error(*poses)) < 1e-6


def test_exact_depths_hold_the_truth():
    data = seen(0.0, 1e-3, 1)
    exact = data_of([Appearance(f"a{i}", "t", tuple(uv), "x", depth=float(z), depth_sigma=1e-3) for i, (uv, z) in enumerate(zip(
        data.uv.tolist(), transform_points(TRUTH, POINTS)[:, 2], strict=True))], CAMERA)  # fmt: skip
    sight = Sight(CAMERA, np.eye(4), POINTS, exact.uv, np.ones(12))
    found = with_depths(TRUTH, sight, np.arange(12), exact, sigma=1.0, huber=3.0)
    assert max(float(e) for e in pose_error(found, TRUTH)) < 1e-9


def test_a_depth_that_cannot_be_right_does_not_count():
    data = seen(0.0, 1e-3, 1)
    data.depth[:6] = 1.2
    sight = Sight(CAMERA, np.eye(4), POINTS, data.uv, np.ones(12))
    found = with_depths(TRUTH, sight, np.arange(12), data, sigma=1.0, huber=3.0)
    assert abs(float(found[2, 3] - TRUTH[2, 3])) < 2e-3
    data.depth[:] = 1.2
    assert with_depths(TRUTH, sight, np.arange(12), data, sigma=1.0, huber=3.0) is TRUTH


def test_without_depths_there_is_nothing_to_add():
    data = data_of([Appearance("a", "t", (1.0, 2.0), "x")], CAMERA)
    assert data.depth is None
    assert side_sight(TRUTH, POINTS[:1], np.array([0]), data, 1.0) is None
    some = data_of(
        [Appearance("a", "t", (1.0, 2.0), "x"), Appearance("b", "t", (1.0, 2.0), "x", depth=1.0, depth_sigma=0.1)],
        CAMERA,
    )
    assert side_sight(TRUTH, POINTS[:1], np.array([0]), some, 1.0) is None
    assert some.only(np.array([False, True])).depth.tolist() == [1.0]
