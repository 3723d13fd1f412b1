"""One pose from several cameras of known places."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, look_at, pose_error, rotation_from_quat_xyzw, transform_points
from geometry.poses.refine import Sight, refine_poses, refine_sights, turned_step

CAMERA = Camera(
    640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]), np.array([0.1, -0.05, 0.001, 0.002, 0.01])
)
POINTS = np.random.default_rng(3).uniform(-0.15, 0.15, (12, 3))
TRUTH = from_rotation_translation(rotation_from_quat_xyzw([0.1, 0.3, -0.2, 0.9]), [0.02, 0.05, 0.1])


def sight(eye, noise=0.0, seed=0, weight=1.0):
    camera_from_world = look_at(eye, [0.0, 0.0, 0.1])
    uv = CAMERA.project(transform_points(camera_from_world @ TRUTH, POINTS))
    uv += np.random.default_rng(seed).normal(0.0, noise, uv.shape) if noise else 0.0
    return Sight(CAMERA, camera_from_world, POINTS, uv, np.full(len(POINTS), weight))


def off(pose):
    return [float(e) for e in pose_error(pose, TRUTH)]


def started(turn=0.05, move=0.03):
    return TRUTH @ from_rotation_translation(rotation_from_quat_xyzw([turn, -turn, turn, 1.0]), [move, -move, move])


def test_the_pose_is_found_again_from_exact_sights():
    found = refine_sights(started(), [sight([1.0, -1.0, 0.8]), sight([-1.0, -1.2, 0.6])], iterations=20)
    assert max(off(found)) < 1e-8


def test_one_sight_is_what_one_camera_refines():
    only = sight([1.0, -1.0, 0.8], noise=1.0)
    found = refine_sights(started(), [only], iterations=30)
    alone, _, _ = refine_poses(
        (only.camera_from_world @ started())[None], POINTS[None], only.uv[None], only.weights[None], CAMERA, 30
    )
    assert np.allclose(only.camera_from_world @ found, alone[0], atol=1e-6)


def test_two_sides_fix_the_depth_that_one_tells_badly():
    pairs = []
    for seed in range(8):
        one, other = sight([0.0, -1.5, 0.4], 1.0, seed), sight([1.5, 0.0, 0.4], 1.0, 100 + seed)
        pairs.append([off(refine_sights(started(), some, 30))[1] for some in ([one], [one, other])])
    alone, both = np.mean(pairs, axis=0)
    assert both < 0.5 * alone


def test_a_sight_of_little_weight_says_little():
    good, bad = sight([1.0, -1.0, 0.8]), sight([-1.0, -1.2, 0.6], noise=30.0, weight=1e-9)
    assert max(off(refine_sights(started(), [good, bad], 30))) < 1e-3


def test_it_gets_no_worse_and_stays_without_a_sight():
    pose = started()
    assert np.array_equal(refine_sights(pose, []), pose)
    exact = sight([1.0, -1.0, 0.8])
    assert np.allclose(refine_sights(TRUTH, [exact], 5), TRUTH, atol=1e-12)


def test_shapes_that_do_not_fit_are_refused():
    wrong = sight([1.0, -1.0, 0.8])._replace(weights=np.ones(3))
    with pytest.raises(GeometryError, match="must agree in B and N"):
        refine_sights(TRUTH, [wrong])


def test_a_step_is_turned_as_its_two_directions_are():
    R = rotation_from_quat_xyzw([0.2, 0.1, 0.4, 0.88])
    w, v = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 2.0])
    assert np.allclose(turned_step(R) @ np.concatenate([w, v]), np.concatenate([R @ w, R @ v]))
