"""Laws by hand, and the oracle: a dense raster of rays shot through every pixel."""

import time

import numpy as np
import pytest
import shapely
from geometry_bodies import CAMERA, LENS, at, bodies, box, bracket, posed, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw, transform_points
from geometry.visibility.outline import image_area, is_closed, outline


@pytest.mark.parametrize("camera", [CAMERA, LENS])
@pytest.mark.parametrize("body", range(3))
def test_outline_equals_a_dense_raster(camera, body):
    rng = np.random.default_rng(body)
    surface = posed(bodies()[body], from_rotation_translation(random_rotations(rng, 1)[0], [0.1, 0.1, 4]))
    area = outline(surface.vertices, surface.triangles, surface.camera_from_object, camera)
    uv = np.stack(np.meshgrid(np.arange(0, 640, 3.0), np.arange(0, 480, 3.0)), axis=-1).reshape(-1, 2)
    inside = shapely.contains_xy(area, uv[:, 0], uv[:, 1])
    hit = np.isfinite(surface.depth(camera.rays(uv)))
    differ = uv[inside != hit]
    assert inside.sum() > 1000
    assert area.is_valid
    edge = shapely.distance(area.boundary, shapely.points(differ)) if len(differ) else np.zeros(1)
    assert edge.max() < 0.05  # px: a bent edge between its points, and single precision, no more


def test_a_square_face_on_has_the_image_computed_by_hand():
    area = outline(*box(1, 1, 1), at(0, 0, 3), CAMERA)
    assert area.equals_exact(shapely.box(220, 140, 420, 340), 1e-9) or area.symmetric_difference(
        shapely.box(220, 140, 420, 340)
    ).area == pytest.approx(0, abs=1e-6)


def test_a_hole_is_seen_through():
    vertices, triangles = bracket()
    area = outline(vertices, triangles, at(0, 0, 4), CAMERA)
    middle = CAMERA.project([0, 0.4, 4.4])  # within the U
    assert not area.contains(shapely.Point(middle))
    assert area.convex_hull.contains(shapely.Point(middle))


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4), st.integers(0, 2))
def test_every_projected_vertex_lies_on_its_outline(quat, body):
    if np.linalg.norm(quat) < 0.1:
        quat = [0, 0, 0, 1]
    vertices, triangles = bodies()[body]
    pose = from_rotation_translation(rotation_from_quat_xyzw(quat), [0.2, 0.1, 5])
    area = outline(vertices, triangles, pose, CAMERA)
    pixels = CAMERA.project(transform_points(pose, vertices))
    assert shapely.distance(area, shapely.points(pixels)).max() < 1e-6
    assert area.is_valid


@pytest.mark.parametrize("body", range(3))
def test_front_facing_triangles_give_the_union_of_all(body):
    vertices, triangles = bodies()[body]
    rng = np.random.default_rng(body)
    pose = from_rotation_translation(random_rotations(rng, 1)[0], [0.1, 0.1, 4])
    pixels = CAMERA.project(transform_points(pose, vertices))
    whole = shapely.union_all([shapely.Polygon(pixels[triangle]).buffer(0) for triangle in triangles])
    assert outline(vertices, triangles, pose, CAMERA).symmetric_difference(whole).area < 1e-6
    turned_inside_out = outline(vertices, triangles[:, ::-1], pose, CAMERA)
    assert turned_inside_out.symmetric_difference(whole).area < 1e-6


def test_an_open_surface_has_an_outline_too():
    vertices, triangles = box()
    open_box = triangles[2:]  # without one facet
    assert is_closed(triangles)
    assert not is_closed(open_box)
    pose = from_rotation_translation(rotation_from_quat_xyzw([0.4, 0.2, 0.1, 1]), [0, 0, 4])
    pixels = CAMERA.project(transform_points(pose, vertices))
    whole = shapely.union_all([shapely.Polygon(pixels[triangle]).buffer(0) for triangle in open_box])
    assert outline(vertices, open_box, pose, CAMERA).symmetric_difference(whole).area < 1e-6


def test_what_reaches_behind_the_camera_is_cut_at_the_near_plane():
    area = outline(*box(1, 1, 4), at(2, 0, -1), CAMERA)  # beside the camera, from 1 m behind to 3 m before it
    assert area.is_valid
    assert area.bounds[2] > 1e5
    assert area.bounds[0] == pytest.approx(320 + 600 * 1.5 / 3)


def test_what_is_behind_the_camera_has_no_outline():
    assert outline(*box(), at(0, 0, -5), CAMERA).is_empty
    assert outline(*box(), at(0, 0, -5), LENS).is_empty


def test_the_image_area_holds_what_the_camera_contains():
    assert image_area(CAMERA).bounds == (-0.5, -0.5, 639.5, 479.5)


def test_an_outline_of_fifty_triangles_takes_under_five_milliseconds():
    vertices, triangles = bracket()
    pose = from_rotation_translation(rotation_from_quat_xyzw([0.4, 0.2, 0.1, 1]), [0, 0, 4])
    times = []
    for _ in range(15):
        start = time.perf_counter()
        outline(vertices, triangles, pose, CAMERA)
        times.append(time.perf_counter() - start)
    assert np.median(times) < 0.005
