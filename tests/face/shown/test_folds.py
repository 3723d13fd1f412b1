"""Folds of a scanned surface are where its true edges are seen, and a round one has none."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import trimesh
from test_edges import box, length, scene

from geometry.visibility.rays import RayMesh
from plogic.face.shown.edges import MOST_CREASES, creases, edges_of
from plogic.face.shown.folds import folds


def scanned():
    """A cube of 1 m in 3,072 triangles, its vertices off by 2 mm."""
    mesh = trimesh.creation.box((1, 1, 1))
    for _ in range(4):
        mesh = mesh.subdivide()
    return mesh.vertices + np.random.default_rng(3).normal(0, 0.002, mesh.vertices.shape), mesh.faces


def test_folds_of_a_scanned_cube_are_its_edges_that_are_seen():
    true = [s for s in edges_of(scene(box("h1", (0, 0, 4), 0.7)))["h1"] if s.inner and not s.self_hidden]
    vertices, faces = scanned()
    assert len(creases(vertices, faces)) > MOST_CREASES
    document = scene(box("h1", (0, 0, 4), 0.7))
    document["assets"]["meshes"]["cube"] = {"vertices": vertices.tolist(), "triangles": faces.tolist()}
    found = edges_of(document)["h1"]
    edges = shapely.MultiLineString([s.points for s in true])
    lines = shapely.MultiLineString([s.points for s in found if s.inner])
    assert len(lines.geoms) >= 1
    assert max(edges.distance(shapely.Point(p)) for p in shapely.get_coordinates(lines)) < 4.0
    assert lines.buffer(4.0).intersection(edges).length > 0.75 * edges.length
    assert length(found, lambda s: s.inner and s.self_hidden) < 0.1 * lines.length


def test_a_rejected_hypothesis_has_no_folds():
    vertices, faces = scanned()
    document = scene(box("h1", (0, 0, 4), 0.7, status="rejected"))
    document["assets"]["meshes"]["cube"] = {"vertices": vertices.tolist(), "triangles": faces.tolist()}
    assert [s.inner for s in edges_of(document)["h1"]] == [False]


def posed(z):
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


@pytest.mark.parametrize("z", [3.0, 0.4])  # before the camera, and around it
def test_a_ball_has_no_folds(z):
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.5)
    assert folds(RayMesh(ball.vertices, ball.faces), posed(z)) == []


def test_a_step_is_a_fold_on_its_nearer_side():
    low, high = trimesh.creation.box((1, 1, 0.01)), trimesh.creation.box((0.4, 0.4, 0.01))
    high.apply_translation([0, 0, -0.5])
    both = trimesh.util.concatenate([low, high])
    lines = folds(RayMesh(both.vertices, both.faces), posed(3.0))
    points = np.concatenate(lines)
    assert np.allclose(points[:, 2], 2.495, atol=0.02)
    assert np.allclose(np.abs(points[:, :2]).max(axis=1), 0.2, atol=0.02)
    assert sum(len(line) for line in lines) > 300
