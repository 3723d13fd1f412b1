"""Triples: three points of a plane and their image give the pose in closed form, up to a reflection (Huttenlocher)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, camera_pose, perceiver, scene, towers

from geometry.frames import rotation_angle, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.hand.triples import ImageTriples, PlaneTriples, image_triples, plane_triples, triple_poses, turn_z_to
from sensing.appearance import Appearance

WIDE = (1.0, 1e6)
RAYS = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4))


def one_triple(points):
    """The plane of three points of the object's xy plane, normal +z."""
    sides = (points[1:, :2] - points[0, :2]).T
    return PlaneTriples(np.array([[0, 1, 2]]), np.eye(3)[None], sides[None])


def weak_image(rotation, ray, scale, points):
    """Weak perspective about a ray: the frame turns the optical axis to the ray; sides are scaled and flattened."""
    frame = turn_z_to(ray[None])[0]
    local = frame.T @ rotation
    sides = scale * (local @ (points[1:] - points[0]).T)[:2]
    return ImageTriples(np.array([[0, 1, 2]]), frame[None], sides[None])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(RAYS, st.floats(0.0, 1.2), st.floats(0.0, 6.28), st.floats(0.0, 6.28), st.floats(0.05, 2.0))
def test_an_exact_triple_gives_the_true_rotation_among_the_two_reflections(place, slant, towards, roll, scale):
    points = np.array([[0.2, 0.1, 0.0], [0.5, 0.15, 0.0], [0.15, 0.45, 0.0]])
    ray = np.array([*place, 1.0]) / np.linalg.norm([*place, 1.0])
    rotation = turn_z_to(ray[None])[0] @ facing(slant, towards, roll)
    poses = triple_poses(one_triple(points), weak_image(rotation, ray, scale, points), points, (1e-9, 1e9), 1.0)
    assert len(poses) == 2
    assert rotation_angle(np.swapaxes(poses[:, :3, :3], 1, 2) @ rotation).min() < 1e-5
    assert np.allclose(poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2), np.eye(3), atol=1e-6)
    assert np.allclose(transform_points(poses, points)[:, 0], ray / scale)


def facing(slant, towards, roll):
    """A rotation that shows the outside (+z) of a plane to the camera, slanted by less than 69°."""
    half_turn = np.diag([1.0, -1.0, -1.0])
    axis = np.array([np.cos(towards), np.sin(towards), 0.0])
    cross = np.array([[0, 0, axis[1]], [0, 0, -axis[0]], [-axis[1], axis[0], 0]])
    tilt = np.eye(3) + np.sin(slant) * cross + (1 - np.cos(slant)) * cross @ cross
    turned = np.array([[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]])
    return tilt @ turned @ half_turn


def test_both_reflections_reproject_alike():
    points = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.3, 0]])
    ray = np.array([0.0, 0.0, 1.0])
    poses = triple_poses(
        one_triple(points), weak_image(facing(0.7, 0.4, 1.0), ray, 0.2, points), points, (1e-9, 1e9), 1.0
    )
    assert np.allclose(poses[0, :2, :2], poses[1, :2, :2])
    assert rotation_angle(poses[0, :3, :3].T @ poses[1, :3, :3]) > 0.5


def test_a_wall_seen_edge_on_is_refused():
    points = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.3, 0]])
    image = weak_image(facing(np.radians(80), 0.4, 1.0), np.array([0.0, 0, 1.0]), 0.2, points)
    assert len(triple_poses(one_triple(points), image, points, (1e-9, 1e9), 1.0)) == 0


def test_scales_outside_the_range_are_refused():
    points = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.3, 0]])
    image = weak_image(facing(0.3, 0.4, 1.0), np.array([0.0, 0, 1.0]), 0.2, points)
    assert len(triple_poses(one_triple(points), image, points, (150.0, 1e9), 600.0)) == 0
    assert len(triple_poses(one_triple(points), image, points, (100.0, 150.0), 600.0)) == 2


@settings(max_examples=40, deadline=None, derandomize=True)
@given(RAYS)
def test_the_smallest_rotation_takes_the_axis_to_the_ray(place):
    ray = np.array([*place, 1.0]) / np.linalg.norm([*place, 1.0])
    turned = turn_z_to(ray[None])[0]
    assert np.allclose(turned @ [0, 0, 1], ray)
    assert np.allclose(turned @ turned.T, np.eye(3))
    assert rotation_angle(turned) == pytest.approx(np.arccos(ray[2]), abs=1e-6)


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_plane_triples_lie_on_one_wall_counter_clockwise_from_outside(name):
    features = towers().type(name).features
    triples = plane_triples(features)
    at = np.array([f.at for f in features])
    assert len(triples.features) > 20
    u, v = (at[triples.features[:, k]] - at[triples.features[:, 0]] for k in (1, 2))
    outward = np.array([features[f].rotation @ features[f].appearances[0].lobe.axis for f in triples.features[:, 0]])
    assert ((np.cross(u, v) * outward).sum(axis=1) > 0).all()
    assert np.allclose(np.einsum("mij,mj->mi", triples.axes, u)[:, :2], triples.sides[:, :, 0])
    assert np.allclose(np.einsum("mij,mj->mi", triples.axes, v)[:, 2], 0.0, atol=1e-6)


def test_no_plain_features_no_triples():
    corners = [f for f in towers().type("t1").features if len(f.arms)]
    assert plane_triples(corners).features.shape == (0, 3)


def test_image_triples_are_counter_clockwise_for_the_eye_and_take_grids_first():
    grid = [(100.0 + 30 * i, 100.0 + 30 * j) for i in range(3) for j in range(3)]
    stray = [(400.0, 300.0), (433.0, 310.0), (420.0, 345.0)]
    data = data_of([Appearance(f"a{i}", "patch", uv, "drawn") for i, uv in enumerate(grid + stray)], CAMERA)
    found = image_triples(data, np.arange(len(data.ids)))
    step = data.ideal[found.data[:, 1:]] - data.ideal[found.data[:, :1]]
    assert (step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0] < 0).all(), "y points down"
    assert (found.data[:4] < 9).all()


def test_fewer_than_three_data_make_no_triple():
    data = data_of(
        [Appearance("a", "patch", (1.0, 2.0), "drawn"), Appearance("b", "patch", (9.0, 2.0), "drawn")], CAMERA
    )
    assert image_triples(data, np.arange(2)).data.shape == (0, 3)


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_some_triple_of_a_real_view_is_near_the_true_pose(name):
    index, rng = perceiver().models[name], np.random.default_rng(5020)
    pose = camera_pose(rng, (3.0, 6.0))
    data = data_of(scene(rng, {name: pose}).gamma.appearances, CAMERA)
    patches = np.flatnonzero(np.array(data.types) == "patch")
    poses = triple_poses(index.triples, image_triples(data, patches), index.points, (10.0, 2000.0), CAMERA.f)
    turned = [
        rotation_angle(np.swapaxes(poses[:, :3, :3], 1, 2) @ (pose @ s)[:3, :3]).min()
        for s in index.object_type.symmetries
    ]
    assert np.degrees(min(turned)) < 15.0


def test_no_triples_no_poses():
    nothing = PlaneTriples(np.zeros((0, 3), dtype=np.intp), np.zeros((0, 3, 3)), np.zeros((0, 2, 2)))
    image = ImageTriples(np.zeros((0, 3), dtype=np.intp), np.zeros((0, 3, 3)), np.zeros((0, 2, 2)))
    assert triple_poses(nothing, image, np.zeros((4, 3)), WIDE, 600.0).shape == (0, 4, 4)
