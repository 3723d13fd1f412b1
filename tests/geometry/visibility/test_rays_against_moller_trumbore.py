"""Oracle: every ray against every triangle, by Moller and Trumbore, in double precision."""

import numpy as np
import pytest
from geometry_bodies import at, bodies, box, bracket, random_rotations, wedge

from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, inverse, look_at, transform_points
from geometry.visibility.rays import RayMesh, behind, depth_of


def moller_trumbore(vertices, triangles, origins, directions):
    a, b, c = (vertices[triangles[:, k]][None] for k in range(3))
    d = (directions / np.linalg.norm(directions, axis=1, keepdims=True))[:, None]
    edge1, edge2, s = b - a, c - a, origins[:, None] - a
    p = np.cross(d, edge2)
    det = (edge1 * p).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (s * p).sum(-1) / det
        q = np.cross(s, edge1)
        v = (d * q).sum(-1) / det
        t = (edge2 * q).sum(-1) / det
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return np.where(hit, t, np.inf).min(axis=1)


@pytest.mark.parametrize("body", range(3))
@pytest.mark.parametrize("far", [0.0, 3.0, 300.0])
def test_first_hits_equal_the_dense_oracle(body, far):
    rng = np.random.default_rng(body)
    vertices, triangles = bodies()[body]
    origins = rng.normal(size=(2000, 3))
    origins += far * origins / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-0.8, 0.8, (2000, 3)) - origins
    found = RayMesh(vertices, triangles).first_hit(origins, directions)
    expected = moller_trumbore(vertices, triangles, origins, directions)
    agree = np.isclose(found, expected, rtol=1e-9, atol=1e-9) | (np.isinf(found) & np.isinf(expected))
    assert agree.mean() > 0.998  # single precision decides rays that graze an edge
    assert 0.2 < np.isfinite(expected).mean() <= 1


@pytest.mark.parametrize("body", range(3))
@pytest.mark.parametrize("start", ["one", "many"])
def test_what_is_met_is_what_has_a_first_hit_and_one_place_is_as_good_as_many(body, start):
    rng = np.random.default_rng(20 + body)
    origins = 4.0 * np.eye(3)[:1] if start == "one" else 2.0 * rng.normal(size=(2000, 3))
    surface, directions = RayMesh(*bodies()[body]), rng.uniform(-1.5, 1.5, (2000, 3)) - origins
    distance, triangle = surface.first_triangle(origins, directions)
    assert np.array_equal(surface.meets(origins, directions), np.isfinite(distance))
    assert np.array_equal(np.isfinite(distance), triangle >= 0)
    assert 0.01 < np.isfinite(distance).mean() < 1.0
    spread = np.broadcast_to(origins, directions.shape).copy()
    assert np.array_equal(surface.first_hit(spread, directions), distance)
    spoilt, lame = spread.copy(), directions.copy()
    spoilt[3], lame[5], lame[7] = np.nan, 0.0, np.inf
    found, rest = surface.first_hit(spoilt, lame), ~np.isin(np.arange(2000), (3, 5, 7))
    assert np.array_equal(found[rest], distance[rest])
    assert np.isinf(found[~rest]).all()
    assert np.array_equal(surface.meets(spoilt, lame), np.isfinite(found))


def test_no_rays_meet_nothing():
    surface = RayMesh(*bodies()[0])
    assert surface.meets(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)
    assert not surface.meets(np.zeros((2, 3)), np.zeros((2, 3))).any()


@pytest.mark.parametrize("body", range(3))
def test_behind_equals_the_dense_oracle(body):
    rng = np.random.default_rng(10 + body)
    vertices, triangles = bodies()[body]
    pose = from_rotation_translation(random_rotations(rng, 1)[0], [0.2, -0.1, 5])
    points = rng.uniform([-2, -2, 3], [2, 2, 8], (3000, 3))
    placed = transform_points(pose, vertices)
    hit = moller_trumbore(placed, triangles, np.zeros((3000, 3)), points)
    expected = hit < np.linalg.norm(points, axis=1) - 0.01
    found = behind(points, RayMesh(vertices, triangles), pose, 0.01)
    assert (found == expected).mean() > 0.999
    assert 0.02 < expected.mean() < 0.5


@pytest.mark.parametrize("away", [0.0, 0.5, 2.0, 5.0])
def test_depths_equal_those_of_rays_through_all_pixels(away):
    """About the camera, beside it, and cut by the picture's border."""
    rng = np.random.default_rng(int(10 * away))
    K, size = np.array([[60.0, 0.0, 40.0], [0.0, 62.0, 30.0], [0.0, 0.0, 1.0]]), (80, 60)
    u, v = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    rays = np.stack([(u - 40.0) / 60.0, (v - 30.0) / 62.0, np.ones(u.shape)], axis=-1).reshape(-1, 3)
    seen = 0
    for vertices, triangles in bodies():
        for turn in random_rotations(rng, 5):
            mesh = RayMesh(vertices, triangles)
            pose = from_rotation_translation(turn, [*rng.uniform(-2.0, 2.0, 2), away])
            far = mesh.first_hit(inverse(pose)[:3, 3][None], rays @ pose[:3, :3]) / np.linalg.norm(rays, axis=1)
            np.testing.assert_allclose(depth_of(mesh, pose, K, size).ravel(), far, rtol=1e-9)
            seen += int(np.isfinite(far).sum())
    assert seen > 1000


def test_a_box_hides_its_own_far_corners_and_no_others():
    vertices, triangles = box()
    pose = at(0, 0, 5, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))  # its z is up on the image, its -y turned to us
    pose = pose @ at(0, 0, -1.5)  # seen from above
    hidden = behind(transform_points(pose, vertices), RayMesh(vertices, triangles), pose)
    is_far_below = (vertices[:, 1] > 0) & (vertices[:, 2] < 0.5)
    assert hidden.tolist() == is_far_below.tolist()


@pytest.mark.parametrize("body", [box(0.7, 0.7, 1), wedge()])
def test_a_convex_bodys_corner_is_hidden_where_all_its_faces_turn_away(body):
    """Oracle: the signs of the facets' planes, from 300 viewpoints."""
    vertices, triangles = body
    mesh, rng = RayMesh(vertices, triangles), np.random.default_rng(0)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    eyes = rng.normal(size=(300, 3))
    eyes = eyes / np.linalg.norm(eyes, axis=1, keepdims=True) * rng.uniform(3, 9, (300, 1)) + [0, 0, 0.7]
    turned_to_us = np.einsum("ti,vti->vt", np.cross(b - a, c - a), eyes[:, None] - a) > 0
    owns = np.array([(triangles == k).any(axis=1) for k in range(len(vertices))])
    expected = ~(turned_to_us[:, None] & owns).any(axis=-1)
    poses = [look_at(eye, [0, 0, 0.7], [0.1, 0.2, 1]) for eye in eyes]
    found = [behind(transform_points(pose, vertices), mesh, pose) for pose in poses]
    assert np.array_equal(found, expected)
    assert 0.05 < expected.mean() < 0.5


def test_points_on_the_surface_are_not_behind_it_where_it_faces_us():
    vertices, triangles = box()
    pose = at(0, 0, 4)
    middles = vertices[triangles].mean(axis=1)
    hidden = behind(transform_points(pose, middles), RayMesh(vertices, triangles), pose)
    facing = middles[:, 2] < 1e-9  # the cap at z = 0 is nearest; the sides slope away from the axis
    assert not hidden[facing].any()
    assert hidden[~facing].all()


def test_behind_does_not_depend_on_the_frame():
    rng = np.random.default_rng(4)
    vertices, triangles = bracket()
    pose = from_rotation_translation(random_rotations(rng, 1)[0], [0, 0, 5])
    other = from_rotation_translation(random_rotations(rng, 1)[0], [4, 5, 6])
    points = rng.uniform([-2, -2, 3], [2, 2, 8], (1000, 3))
    moved = RayMesh(transform_points(other, vertices), triangles)
    here = behind(points, RayMesh(vertices, triangles), pose, 0.01)
    assert (behind(points, moved, pose @ inverse(other), 0.01) == here).mean() > 0.999
    assert here.any()


def test_rays_that_are_none_hit_nothing():
    mesh = RayMesh(*box())
    origins = np.array([[0, 0, -3], [0, 0, -3], [0, 0, np.nan], [0, 0, -3]], dtype=float)
    directions = np.array([[0, 0, 7], [0, 0, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    distance, triangle = mesh.first_triangle(origins, directions)
    assert distance.tolist() == [3, np.inf, np.inf, np.inf]
    assert (triangle >= 0).tolist() == [True, False, False, False]
    assert mesh.first_hit(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


def test_the_tolerance_excludes_the_surface_at_the_point():
    mesh = RayMesh(*box())
    points = np.array([[0, 0, -0.1], [0, 0, 0], [0, 0, 0.02], [0, 0, 0.5]])
    assert mesh.blocks([0, 0, -5], points, 0.03).tolist() == [False, False, False, True]
    assert mesh.blocks([0, 0, -5], points, 0.01).tolist() == [False, False, True, True]


def test_a_viewpoint_for_each_point_is_each_viewpoint_by_itself():
    rng = np.random.default_rng(3)
    mesh, eyes, points = RayMesh(*bodies()[2]), rng.normal(0.0, 4.0, (60, 3)), rng.uniform(-1.0, 1.0, (60, 3))
    hidden = mesh.blocks(eyes, points, 0.01)
    assert hidden.tolist() == [mesh.blocks(eye, point[None], 0.01)[0] for eye, point in zip(eyes, points, strict=True)]
    assert 0.1 < hidden.mean() < 0.9


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "triangles must have the shape"),
        (np.eye(3), [[0, 1, 3]], "must index the 3 vertices"),
        (np.eye(3) * np.nan, [[0, 1, 2]], "vertex 0 must be finite"),
        (np.eye(2), [[0, 1, 2]], "vertices must have the shape"),
    ],
)
def test_broken_surfaces_are_named(vertices, triangles, message):
    with pytest.raises(GeometryError, match=message):
        RayMesh(vertices, triangles)
