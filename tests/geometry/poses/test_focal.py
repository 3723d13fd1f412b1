"""Whether matched points agree with a focal length: what is told of it is as sure as it says."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from geometry.camera import centred_camera
from geometry.frames import from_rotation_translation, transform_points, turn_about
from geometry.poses.focal import error_by_groups, focal_fit
from geometry.poses.refine import refine_poses

RIGHT = centred_camera((640, 480), 600.0)


def seen(rng, count=30, noise=1.0, depth=4.0):
    """Points of a box (N, 3) m, and their noisy images (N, 2) under the right camera; the pose."""
    points = rng.uniform([-0.5, -0.4, -0.6], [0.5, 0.4, 0.6], (count, 3))
    turn = turn_about([0, 1, 0], rng.uniform(-3, 3)) @ turn_about([1, 0, 0], rng.uniform(-3, 3))
    pose = from_rotation_translation(turn, [rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), depth])
    return points, RIGHT.project(transform_points(pose, points)) + rng.normal(0, noise, (count, 2)), pose


def best(points, uv, camera, pose):
    """The pose that is best under a camera, as the search leaves it."""
    start = pose.copy()
    start[2, 3] *= camera.f / RIGHT.f
    poses, _, _ = refine_poses(start[None], points[None], uv[None], np.ones((1, len(points))), camera, 50)
    return poses[0]


def test_the_standard_error_is_that_of_what_is_found():
    rng = np.random.default_rng(0)
    found = []
    for _ in range(300):
        points, uv, pose = seen(rng)
        fit = focal_fit(points, uv, RIGHT, best(points, uv, RIGHT, pose))
        found.append(fit.log / (fit.noise * fit.error))
    assert abs(np.mean(found)) < 0.2
    assert 0.85 < np.std(found) < 1.15
    assert np.abs(found).max() < 4.0


@pytest.mark.parametrize("wrong", [0.7, 0.85, 1.25, 1.6])
def test_a_wrong_focal_length_is_seen_and_the_right_one_and_the_pose_found(wrong):
    rng = np.random.default_rng(1)
    camera = centred_camera((640, 480), 600.0 * wrong)
    for _ in range(20):
        points, uv, pose = seen(rng, noise=0.5, depth=2.5)
        fit = focal_fit(points, uv, camera, best(points, uv, camera, pose))
        sure = fit.noise * fit.error
        assert fit.log / sure * np.sign(1.0 - wrong) > 4.0
        assert abs(fit.log + np.log(wrong)) < 5.0 * sure
        assert sure < 0.1
        assert np.linalg.norm(fit.pose[:3, 3] - pose[:3, 3]) < 0.3
        assert fit.noise == pytest.approx(0.5, abs=0.2)


def test_it_is_scipys_least_squares():
    rng = np.random.default_rng(3)
    points, uv, pose = seen(rng, noise=0.7, depth=2.5)

    def off(x):
        moved = from_rotation_translation(Rotation.from_rotvec(x[1:4]).as_matrix() @ pose[:3, :3], pose[:3, 3] + x[4:])
        placed = transform_points(moved, points)
        return (placed[:, :2] / placed[:, 2:] * 600.0 * np.exp(x[0]) + RIGHT.K[:2, 2] - uv).ravel()

    answer = least_squares(off, np.zeros(7), method="lm", xtol=1e-14, ftol=1e-14)
    fit = focal_fit(points, uv, RIGHT, pose)
    assert fit.log == pytest.approx(answer.x[0], abs=1e-6)
    assert fit.noise == pytest.approx(np.sqrt((answer.fun**2).sum() / (2 * len(points) - 7)), abs=1e-6)
    covariance = np.linalg.inv(answer.jac.T @ answer.jac)
    assert fit.error == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-4)


def test_what_fixes_no_focal_length_says_nothing():
    rng = np.random.default_rng(2)
    flat = np.concatenate([rng.uniform(-0.5, 0.5, (20, 2)), np.zeros((20, 1))], axis=1)
    pose = from_rotation_translation(np.eye(3), [0, 0, 4.0])
    uv = RIGHT.project(transform_points(pose, flat))
    assert focal_fit(flat, uv, RIGHT, pose).error > 2.0
    behind = from_rotation_translation(np.eye(3), [0, 0, -4.0])
    assert focal_fit(flat, uv, RIGHT, behind).error == np.inf


def test_errors_that_neighbours_share_are_told_by_groups_alone():
    """Each eighth of the box is drawn half a pixel aside, as print is on a mesh that is not quite the object."""
    rng = np.random.default_rng(4)
    plain, grouped = [], []
    for _ in range(40):
        points, uv, pose = seen(rng, count=160, noise=0.5, depth=4.0)
        uv = uv + rng.normal(0, 0.5, (8, 2))[(points > 0) @ [1, 2, 4]]
        fit = focal_fit(points, uv, RIGHT, pose)
        plain.append(fit.log / (fit.noise * fit.error))
        grouped.append(fit.log / error_by_groups(points, uv, RIGHT, fit))
    assert np.std(plain) > 2.0
    assert np.std(grouped) < 0.75 * np.std(plain)


def test_few_points_are_left_out_one_by_one():
    points, uv, pose = seen(np.random.default_rng(5), count=7)
    fit = focal_fit(points, uv, RIGHT, pose)
    logs = [focal_fit(np.delete(points, i, 0), np.delete(uv, i, 0), RIGHT, fit.pose).log for i in range(7)]
    told = error_by_groups(points, uv, RIGHT, fit)
    assert told == pytest.approx(np.sqrt(6.0 / 7.0 * ((logs - np.mean(logs)) ** 2).sum()), rel=1e-6)
