"""Meshes as they come: split along seams, open, inside out, doubled, huge in number; and what is made of them."""

import numpy as np
import pytest
import trimesh
from made_meshes import CORNERS, box_triangles, split_box

from kb.errors import IntakeError
from kb.surfaces.closing import rims, turned_outward
from kb.surfaces.nearness import Nearness, spread
from kb.surfaces.repair import DEVIATIONS, FEW, repaired
from kb.surfaces.surface import Surface
from kb.surfaces.symmetries import turns_of


def test_seams_are_welded():
    vertices, triangles, _ = split_box()
    done = repaired(vertices, triangles)
    assert done.surface.faults == ""
    assert (done.vertices, done.welded, len(done.surface.vertices)) == (24, 16, 8)
    assert done.surface.volume == pytest.approx(1)


@pytest.mark.parametrize("seed", range(4))
def test_facets_that_face_any_way_are_turned_outward(seed):
    triangles = box_triangles()
    turned = np.random.default_rng(seed).random(len(triangles)) < 0.5
    triangles[turned] = triangles[turned][:, ::-1]
    assert Surface(CORNERS, turned_outward(CORNERS, triangles)).volume == pytest.approx(1)


def test_a_hollow_body_keeps_its_inner_wall():
    vertices = np.concatenate([CORNERS, 0.25 + CORNERS / 2])
    triangles = np.concatenate([box_triangles(), box_triangles()[:, ::-1] + 8])
    assert repaired(vertices, triangles).surface.volume == pytest.approx(1 - 1 / 8)


def test_a_small_hole_is_filled_and_a_large_one_left_open():
    ball = trimesh.creation.icosphere(subdivisions=3)
    vertices, triangles = np.array(ball.vertices), np.array(ball.faces)
    top = int(vertices[:, 2].argmax())
    small = repaired(vertices, triangles[~(triangles == top).any(axis=1)])
    assert (small.holes, small.left, small.surface.closed) == (1, 0, True)
    bowl = repaired(vertices, triangles[vertices[triangles][:, :, 2].mean(axis=1) < 0.3])
    assert (bowl.holes, bowl.left, bowl.surface.closed) == (0, 1, False)
    assert bowl.surface.solid is None


def test_rims_are_found_with_their_vertices_once():
    (loop,) = rims(box_triangles()[2:])
    assert sorted(loop.tolist()) == [0, 1, 2, 3]
    assert rims(box_triangles()) == []


def test_triangles_that_are_there_twice_or_degenerate_are_dropped():
    extra = [[0, 1, 3], [0, 0, 1], [0, 1, 0]]
    done = repaired(CORNERS, np.concatenate([box_triangles(), extra]))
    assert (done.dropped, done.surface.closed) == (3, True)


def test_a_flap_is_cut_off_and_a_sheet_drawn_from_both_sides_is_kept_once():
    ball = trimesh.creation.icosphere(subdivisions=2)
    apex = np.array([[0.0, 0, 1.5]])
    number = len(ball.vertices)
    a, b = ball.faces[0][:2]
    flap = [[a, b, number], [b, a, number]]
    done = repaired(np.concatenate([ball.vertices, apex]), np.concatenate([ball.faces, flap]))
    assert done.surface.closed
    assert len(done.surface.triangles) == len(ball.faces)
    sheet = np.array([[0, 1, 3], [0, 3, 2]])
    both = repaired(CORNERS, np.concatenate([sheet, sheet[:, ::-1]]))
    assert (len(both.surface.triangles), both.surface.closed, both.surface.solid) == (2, False, None)


def test_bodies_that_touch_along_a_wall_become_one():
    vertices = np.concatenate([CORNERS, CORNERS + np.array([1, 0, 0])])
    done = repaired(vertices, np.concatenate([box_triangles(), box_triangles() + 8]))
    assert done.surface.closed
    assert done.surface.volume == pytest.approx(2)


def test_all_degenerate_is_an_error():
    with pytest.raises(IntakeError, match="degenerate"):
        repaired(CORNERS, np.array([[0, 0, 1], [2, 2, 2]]))


@pytest.mark.parametrize("opened", [False, True])
def test_many_triangles_become_few_near_the_mesh(opened):
    ball = trimesh.creation.icosphere(subdivisions=5)
    triangles = np.array(ball.faces)
    if opened:
        triangles = triangles[np.array(ball.vertices)[triangles][:, :, 2].mean(axis=1) < 0.3]
    done = repaired(np.array(ball.vertices), triangles)
    assert done.triangles > 2 * FEW >= 2 * len(done.surface.triangles)
    assert done.surface.closed is not opened
    assert 0 < done.deviation < 2 * DEVIATIONS[-1] * done.surface.diameter
    assert done.surface.vertices[:, 2].max() == pytest.approx(
        1 if not opened else np.array(ball.vertices)[np.unique(triangles), 2].max(), abs=0.02
    )
    radii = np.linalg.norm(spread(done.surface.vertices, done.surface.triangles, 3000)[0], axis=1)
    assert np.abs(radii - 1).max() <= done.deviation + 1e-3


def test_nearness_is_the_distance_to_the_triangles():
    near = Nearness(CORNERS, box_triangles())
    points = np.array([[0.5, 0.5, 2], [0.5, 0.5, 0.9], [2, 2, 2], [1.5, 1.5, 0.5]])
    assert near.distance(points) == pytest.approx([1, 0.1, 3**0.5, 0.5**0.5], abs=1e-9)


def folds(mesh):
    return sorted(turn.fold for turn in turns_of(Surface(np.array(mesh.vertices), np.array(mesh.faces))))


def test_symmetries_of_the_shape_are_found():
    assert folds(trimesh.creation.box(extents=(1, 2, 3))) == [2, 2, 2]
    assert folds(trimesh.creation.box(extents=(1, 1, 3))) == [2, 2, 4]
    assert folds(trimesh.creation.cylinder(radius=1, height=3, sections=64)) == [0, 2, 2]
    assert folds(trimesh.creation.cone(radius=1, height=3, sections=64)) == [0]


def test_the_axes_are_those_of_a_turned_box():
    mesh = trimesh.creation.box(extents=(1, 2, 3))
    turn = trimesh.transformations.rotation_matrix(0.6, [1, 1, 0], [1, 2, 3])
    mesh.apply_transform(turn)
    found = turns_of(Surface(np.array(mesh.vertices), np.array(mesh.faces)))
    assert [turn.fold for turn in found] == [2, 2, 2]
    axes = np.array([t.axis for t in found])
    assert np.abs(axes @ turn[:3, :3]).max(axis=0) == pytest.approx(1, abs=1e-6)
