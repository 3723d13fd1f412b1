"""Faces that bodies stand on, and planes that they stand on: what holds of every pose."""

import numpy as np
import pytest
from geometry_bodies import CAMERA, box, prism, random_rotations, wedge
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.resting import Plane, meant, resting_faces, stated_faces
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, pose_error, transform_points
from geometry.poses.refine import Steps, refine_poses, refined_poses

BODIES = {
    "brick": box(0.2, 0.1, 0.06)[0],
    "wedge": wedge()[0],
    "triangle": prism([(0, 0), (0.3, 0), (0.1, 0.2)], 0.15)[0],
}
seeds = st.integers(0, 9999)


def posed(seed, count=1):
    rng = np.random.default_rng(seed)
    return from_rotation_translation(
        random_rotations(rng, count), np.array([0.0, 0, 3]) + rng.uniform(-1, 1, (count, 3))
    )


def test_a_brick_stands_on_six_sides_the_largest_first():
    faces = resting_faces(BODIES["brick"])
    assert faces.down.shape == (6, 3)
    np.testing.assert_allclose(np.abs(faces.down), np.eye(3)[[2, 2, 1, 1, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(sorted(faces.reach), [0.0, 0.05, 0.05, 0.06, 0.1, 0.1], atol=1e-9)


def test_each_way_to_stand_weighs_the_same_and_sides_of_a_can_are_one_way():
    np.testing.assert_allclose(resting_faces(BODIES["brick"]).weight, np.full(6, 1 / 6))
    around = np.linspace(0.0, 2.0 * np.pi, 33)[:-1]
    can = np.concatenate([np.c_[0.03 * np.cos(around), 0.03 * np.sin(around), np.full(32, z)] for z in (0.0, 0.1)])
    faces = resting_faces(can)
    upright = np.abs(faces.down[:, 2]) > 0.9
    assert len(faces.down) > 10
    np.testing.assert_allclose(faces.weight[upright], [0.25, 0.25])
    np.testing.assert_allclose(faces.weight[~upright], 0.5 / (~upright).sum())


def test_facets_that_are_alike_are_one_face_that_bulges():
    around = np.linspace(0.0, 2.0 * np.pi, 129)[:-1]
    can = np.concatenate([np.c_[0.03 * np.cos(around), 0.03 * np.sin(around), np.full(128, z)] for z in (0.0, 0.1)])
    faces = resting_faces(can)
    upright = np.abs(faces.down[:, 2]) > 0.9
    assert 20 < (~upright).sum() < 128 / 2  # 2.8 degrees apart, told 8 degrees apart and more
    np.testing.assert_allclose(faces.bent[upright], 0.0, atol=1e-7)
    assert (faces.bent[~upright] > np.radians(1.0)).all()
    np.testing.assert_allclose(resting_faces(BODIES["brick"]).bent, 0.0, atol=1e-7)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(sorted(BODIES)), seeds)
def test_weights_sum_to_one_and_stated_ones_are_of_faces(name, seed):
    """However the author's directions lie; what is no face touches the hull all the same."""
    rng = np.random.default_rng(seed)
    points, weight = BODIES[name] * rng.uniform(0.3, 1.0, 3), rng.uniform(0.1, 5.0, 4)
    down = rng.normal(size=(4, 3))
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    free, stated = resting_faces(points), stated_faces(points, down, weight)
    assert free.weight.sum() == pytest.approx(1.0)
    assert stated.weight.sum() == pytest.approx(1.0)
    huge = stated_faces(points, down, weight / weight.max() * 1e308)
    np.testing.assert_allclose(huge.weight, stated.weight)
    np.testing.assert_allclose(stated.reach, (points @ stated.down.T).max(axis=0))
    which = meant(free, down)
    for row, face in zip(down, which, strict=True):
        wanted = row if face < 0 else free.down[face]
        assert (np.abs(stated.down - wanted).max(axis=1) < 1e-6).sum() == 1


def test_a_stated_direction_means_the_face_near_it():
    faces = stated_faces(
        BODIES["brick"], np.array([[0.0, 0.1, -0.995], [0.0, 0.0, -1.0], [0.6, 0.8, 0.0]]), np.arange(1.0, 4.0)
    )
    np.testing.assert_allclose(faces.down, [[0.0, 0.0, -1.0], [0.6, 0.8, 0.0]], atol=1e-9)
    np.testing.assert_allclose(faces.weight, [0.5, 0.5])


def test_what_would_topple_is_no_face_to_stand_on():
    """A tower that leans out over its foot stands on its long sides, not on its foot.

    A needle does not stand on its point.
    """
    leaning = BODIES["brick"] * [0.2, 0.4, 5.0]
    leaning = leaning + np.outer(leaning[:, 2], [0.5, 0.0, 0.0])
    assert not (resting_faces(leaning).down @ [0, 0, -1.0] > 0.99).any()
    assert len(resting_faces(leaning).down) >= 2
    needle = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0], [0, 0, 0.6]])
    assert (resting_faces(needle).down @ [0, 0, 1.0] < 0.9).all()


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.zeros((5, 3)), np.c_[BODIES["brick"][:, :2], np.zeros(8)], BODIES["brick"][:3]]
)
def test_points_without_volume_stand_on_nothing(points):
    assert len(resting_faces(points).down) == 0


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(sorted(BODIES)), seeds)
def test_a_body_touches_the_planes_it_stands_on_from_above(name, seed):
    pose = posed(seed)[0]
    faces = resting_faces(BODIES[name])
    assert len(faces.down) >= 4
    for up, offset in zip(*faces.planes(pose), strict=True):
        heights = Plane(up, offset).height(transform_points(pose, BODIES[name]))
        assert heights.min() == pytest.approx(0.0, abs=1e-9)
        assert np.sort(heights)[2] < 0.02  # corners are rounded to a hundredth of the size


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(sorted(BODIES)), seeds)
def test_a_turned_camera_turns_the_planes(name, seed):
    pose, turn = posed(seed)[0], posed(seed + 1)[0]
    faces = resting_faces(BODIES[name])
    ups, offsets = faces.planes(pose)
    turned, moved = faces.planes(turn @ pose)
    np.testing.assert_allclose(turned, ups @ turn[:3, :3].T, atol=1e-12)
    np.testing.assert_allclose(moved, offsets - turned @ turn[:3, 3], atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seeds)
def test_moves_along_a_plane_leave_heights_as_they_are(seed):
    rng = np.random.default_rng(seed)
    up = rng.normal(size=3)
    plane = Plane(up / np.linalg.norm(up), 0.5)
    step = plane.moves @ rng.normal(size=3)
    places = rng.normal(size=(5, 3))
    np.testing.assert_allclose(plane.up @ step[3:], 0.0, atol=1e-12)
    np.testing.assert_allclose(
        plane.up @ np.cross(step[:3], places).T, 0.0, atol=1e-12
    )  # a small turn about the normal lifts nothing


def scene(seed, noise=0.3):
    """Standing bricks, started off their place on the plane, each seen as eight points."""
    rng = np.random.default_rng(seed)
    truth = posed(seed, 6)
    faces = resting_faces(BODIES["brick"])
    planes = [Plane(*(row[0] for row in faces.planes(pose))) for pose in truth]
    start = truth.copy()
    for pose, plane in zip(start, planes, strict=True):
        w, v = np.split(plane.moves @ (rng.normal(size=3) * [0.1, 0.03, 0.03]), 2)
        angle = np.linalg.norm(w)
        cross = np.cross(np.eye(3), w[None] / angle)
        pose[:3, :3] = (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross) @ pose[:3, :3]
        pose[:3, 3] += v
    points = np.tile(BODIES["brick"], (6, 1, 1))
    uv = CAMERA.project(transform_points(truth, points)) + rng.normal(0, noise, (6, 8, 2))
    return truth, planes, start, points, uv


def test_what_moves_along_its_plane_is_fitted_and_stays_on_it():
    truth, planes, start, points, uv = scene(3, noise=0.0)
    assert len(planes) > 0
    for i, plane in enumerate(planes):
        found = refined_poses(
            start[i : i + 1], points[:1], uv[i : i + 1], np.ones((1, 8)), CAMERA, Steps(4, plane.moves)
        )
        assert np.allclose(pose_error(found[0], truth[i]), 0, atol=1e-3)
        heights = [plane.height(transform_points(pose, points[0])) for pose in (found[0], truth[i])]
        np.testing.assert_allclose(*heights, atol=1e-9)


def test_with_every_way_to_move_it_is_the_free_refinement():
    _, _, start, points, uv = scene(4)
    along = refined_poses(start, points, uv, np.ones((6, 8)), CAMERA, Steps(4, np.eye(6)), huber=1.0)
    assert np.array_equal(along, refine_poses(start, points, uv, np.ones((6, 8)), CAMERA, 4, huber=1.0)[0])
    assert np.array_equal(along, refined_poses(start, points, uv, np.ones((6, 8)), CAMERA, Steps(4), huber=1.0))


def test_moves_of_another_shape_are_told():
    _, _, start, points, uv = scene(5)
    with pytest.raises(GeometryError, match="moves"):
        refined_poses(start, points, uv, np.ones((6, 8)), CAMERA, Steps(4, np.eye(5)))
