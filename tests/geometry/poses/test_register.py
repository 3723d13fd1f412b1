"""Pose and focal length from clicked points: a box's corners with half a pixel of noise, and sets that fix nothing."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.camera import Camera, centred_camera
from geometry.errors import GeometryError
from geometry.frames import look_at, pose_error, transform_points
from geometry.poses.register import register, suspect

BOX = np.array([[x, y, z] for x in (0.0, 0.19) for y in (0.0, 0.26) for z in (0.0, 0.075)])
SEVEN = BOX[1:]
"""Without the corner that a camera before and above does not see."""
SIZE = 1280, 960


def seen(points, camera, noise=0.0, seed=0, eye=(0.45, 0.55, 0.4), target=(0.09, 0.13, 0.04)):
    pose = look_at(eye, target)
    uv = camera.project(transform_points(pose, points))
    return pose, uv + noise * np.random.default_rng(seed).standard_normal(uv.shape)


@pytest.mark.parametrize("f", [900.0, 1400.0, 2500.0])
def test_focal_length_is_exact_without_noise(f):
    pose, uv = seen(SEVEN, centred_camera(SIZE, f))
    found = register(SEVEN, uv, SIZE)
    assert found.camera.f == pytest.approx(f, rel=1e-6)
    assert max(pose_error(found.camera_from_object, pose)) < 1e-6
    assert found.rms < 1e-6


def test_focal_length_within_two_percent_at_half_a_pixel():
    f = 1100.0
    found = [register(SEVEN, seen(SEVEN, centred_camera(SIZE, f), 0.5, seed)[1], SIZE) for seed in range(5)]
    errors = np.array([one.camera.f - f for one in found])
    assert np.sqrt((errors**2).mean()) < 0.02 * f
    assert (np.abs(errors) < 4.0 * np.array([one.f_error for one in found])).all()


def test_pose_with_a_camera_that_distorts():
    camera = Camera(
        *SIZE, np.array([[1000.0, 0, 650], [0, 990, 470], [0, 0, 1]]), np.array([-0.1, 0.02, 0.001, -0.001, 0])
    )
    pose, uv = seen(SEVEN[:4], camera)
    found = register(SEVEN[:4], uv, SIZE, camera)
    assert found.camera is camera
    assert found.f_error == 0.0
    assert found.rms < 1e-6
    assert max(pose_error(found.camera_from_object, pose)) < 1e-4


def test_four_corners_of_one_face_are_enough_with_a_camera():
    face = BOX[BOX[:, 2] > 0.0]
    camera = centred_camera(SIZE, 1200.0)
    pose, uv = seen(face, camera)
    assert max(pose_error(register(face, uv, SIZE, camera).camera_from_object, pose)) < 1e-6


def test_the_wrong_click_is_told():
    _, uv = seen(SEVEN, centred_camera(SIZE, 1200.0), 0.3)
    uv[4] += (25.0, -18.0)
    assert suspect(SEVEN, uv, SIZE) == 4


def test_too_few():
    _, uv = seen(SEVEN, centred_camera(SIZE, 1200.0))
    with pytest.raises(GeometryError, match="5 points are too few: 4 at least with a camera, 6 without"):
        register(SEVEN[:5], uv[:5], SIZE)
    with pytest.raises(GeometryError, match="3 points are too few"):
        register(SEVEN[:3], uv[:3], SIZE, centred_camera(SIZE, 1200.0))


def test_not_finite():
    _, uv = seen(SEVEN, centred_camera(SIZE, 1200.0))
    uv[2, 1] = np.nan
    with pytest.raises(GeometryError, match="point 3 is not finite"):
        register(SEVEN, uv, SIZE)


def test_on_one_line():
    line = np.linspace([0, 0, 0], [0.1, 0.2, 0.3], 7)
    _, uv = seen(line, centred_camera(SIZE, 1200.0))
    with pytest.raises(GeometryError, match="all points lie on one line"):
        register(line, uv, SIZE)


def test_a_face_seen_head_on_fixes_no_focal_length():
    grid = np.array([[x, y, 0.0] for x in (0, 0.1, 0.2) for y in (0, 0.1, 0.2)])
    _, uv = seen(grid, centred_camera(SIZE, 1200.0), 0.3, eye=(0.1, 0.1001, 0.8), target=(0.1, 0.1, 0.0))
    with pytest.raises(GeometryError, match="do not fix the focal length"):
        register(grid, uv, SIZE)
