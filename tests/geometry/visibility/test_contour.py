"""The union of many triangles by their contour, against shapely's union of them all."""

import numpy as np
import pytest
import shapely
import trimesh
from geometry_bodies import CAMERA, random_rotations
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.frames import from_rotation_translation, transform_points
from geometry.visibility.outline import _inside, contour, outline, union_by_contour, winding

BODIES = {
    "ball": lambda: trimesh.creation.icosphere(3),
    "ring": lambda: trimesh.creation.torus(0.4, 0.1, 40, 20),
    "knobs": lambda: trimesh.util.concatenate(
        [
            trimesh.creation.icosphere(2, radius=0.3).apply_translation(place)
            for place in ([0, 0, 0], [0.5, 0, 0.2], [0, 0.9, 0])
        ]
    ),
    "open half": lambda: opened(trimesh.creation.icosphere(3)),
}


def opened(body):
    """What of a body lies at z > -0.1."""
    return trimesh.Trimesh(body.vertices, body.faces[(body.triangles_center[:, 2] > -0.1)], process=False)


@pytest.mark.parametrize("name", BODIES)
def test_many_triangles_have_the_union_of_all_as_their_outline(name):
    body = BODIES[name]()
    turns = random_rotations(np.random.default_rng(0), 8)
    assert len(turns) == 8
    for turn in turns:
        pose = from_rotation_translation(turn, [0.1, -0.2, 3])
        corners = CAMERA.project(transform_points(pose, body.vertices))[body.faces]
        whole = shapely.union_all([shapely.Polygon(triangle).buffer(0) for triangle in corners])
        area = outline(body.vertices, body.faces, pose, CAMERA)
        assert area.is_valid
        assert area.symmetric_difference(whole).area < 1e-6
        assert shapely.hausdorff_distance(outside(area), outside(whole)) < 1e-6


def outside(area):
    """The outer boundary: shapely's union has cracks between neighbours."""
    return shapely.union_all([shapely.Polygon(part.exterior) for part in shapely.get_parts(area)]).boundary


def test_a_ring_is_seen_through_and_has_no_cracks():
    body = BODIES["ring"]()
    area = outline(body.vertices, body.faces, from_rotation_translation(np.eye(3), [0, 0, 3]), CAMERA)
    assert len(area.interiors) == 1
    assert shapely.Polygon(area.interiors[0]).area == pytest.approx(np.pi * (600 * 0.3 / 3) ** 2, rel=0.05)


def test_the_same_surface_has_the_same_outline_to_the_bit():
    body = BODIES["knobs"]()
    pose = from_rotation_translation(random_rotations(np.random.default_rng(1), 1)[0], [0, 0, 3])
    assert (
        outline(body.vertices, body.faces, pose, CAMERA).wkb
        == outline(body.vertices.copy(), body.faces.copy(), pose, CAMERA).wkb
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 40))
def test_any_triangles_even_ones_that_hang_together_nowhere(seed, count):
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(0, 100, (max(3, count), 2))
    triangles = np.array([rng.choice(len(pixels), 3, replace=False) for _ in range(count)])
    whole = shapely.union_all(shapely.polygons(pixels[triangles]))
    assert union_by_contour(pixels, triangles).symmetric_difference(whole).area < 1e-6


def test_no_triangles_cover_nothing():
    assert union_by_contour(np.zeros((3, 2)), np.zeros((0, 3), int)).is_empty


def test_neighbours_cancel_whichever_way_they_are_wound():
    pixels = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    for second in ([0, 2, 3], [3, 2, 0]):
        edges = contour(pixels, np.array([[0, 1, 2], second]))
        assert sorted(edges.tolist()) == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert sorted(contour(pixels, np.array([[0, 1, 2], [2, 1, 0]])).tolist()) == [
        [0, 1],
        [0, 1],
        [1, 2],
        [1, 2],
        [2, 0],
        [2, 0],
    ]


def test_winding_counts_the_turns():
    square = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    starts, ends = (
        np.vstack([square, square, square[::-1] + 10]),
        np.vstack([np.roll(s, -1, axis=0) for s in (square, square, square[::-1] + 10)]),
    )
    assert winding(np.array([[2.0, 1], [11, 11.5], [6, 1], [-3, 2]]), starts, ends).tolist() == [2, -1, 0, 0]


def test_a_slit_of_rounding_inside_parts_nothing():
    """Two columns whose common edge is drawn twice, a last digit apart: the middle of the whole lies on it."""
    right = np.nextafter(2.0, 3.0)
    pixels = np.array(
        [[0, 0], [4, 0], [4, 1], [2, 1], [0, 1], [0, 3], [2, 3], [4, 3], [4, 4], [0, 4], [2, 2], [right, 2]],
        dtype=float,
    )
    below, above = [[0, 1, 2], [0, 2, 3], [0, 3, 4]], [[5, 6, 9], [6, 8, 9], [6, 7, 8]]
    columns = [[4, 3, 10], [4, 10, 5], [5, 10, 6], [3, 2, 11], [2, 7, 11], [7, 6, 11]]
    area = union_by_contour(pixels, np.array(below + columns + above))
    assert area.area == pytest.approx(16.0)
    assert area.is_valid


def test_whether_a_face_is_covered_is_asked_off_all_lines():
    """As a slit lay across a clamp's image, then taken for uncovered (pair 943 of clamps, `plogic bench occlusion`)."""
    faces, slit = np.array([shapely.box(0, 0, 4, 4), shapely.box(4, 0, 6, 4)]), shapely.LineString([(2, 1), (2, 3)])
    assert shapely.distance(shapely.point_on_surface(faces[0]), slit) == 0.0
    points = _inside(faces, slit)
    assert shapely.contains_xy(faces, points[:, 0], points[:, 1]).all()
    assert (shapely.distance(shapely.points(points), slit) > 1e-7).all()
