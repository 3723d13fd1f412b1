"""Faces: maximal convex planar polygons of n ≥ 3 corners."""

import numpy as np
import pytest
import trimesh

from benchmarks.author.towers import t1, t2
from kb.surfaces.faces import Face, faces, normals_of
from kb.surfaces.surface import Surface, welded


def cuboid(steps: int = 0) -> Surface:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    for _ in range(steps):
        box = box.subdivide()
    return welded(np.array(box.vertices), np.array(box.faces))


def el() -> Surface:
    """A prism over an L: two of its flat regions are not convex."""
    ground = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    low, high = np.column_stack([ground, np.zeros(6)]), np.column_stack([ground, np.ones(6)])
    top = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for i in range(6) for j in [(i + 1) % 6] for t in [(i, j, 6 + j), (i, 6 + j, 6 + i)]]
    surface = Surface(
        np.vstack([low, high]),
        np.array([(c, b, a) for a, b, c in top] + [(a + 6, b + 6, c + 6) for a, b, c in top] + sides),
    )
    assert surface.faults == ""
    return surface


def area(surface: Surface, face: Face) -> float:
    p = surface.vertices[list(face.loop)]
    return float(np.cross(p[1:-1] - p[0], p[2:] - p[0]).sum(axis=0) @ face.normal / 2)


@pytest.mark.parametrize("steps", [0, 1, 2])
def test_a_cuboid_has_six_faces_however_fine_its_facets(steps):
    found = faces(cuboid(steps))
    assert [len(face.loop) for face in found] == [4] * 6


def test_a_pyramids_sides_are_faces():
    assert sorted(len(face.loop) for face in faces(t2().surface)) == [3, 3, 3, 3, 4, 4, 4, 4, 4]
    assert [len(face.loop) for face in faces(t1().surface)] == [4] * 6


@pytest.mark.parametrize("surface", [cuboid(), cuboid(1), el(), t1().surface, t2().surface])
def test_laws_of_faces(surface):
    found = faces(surface)
    assert sorted(t for face in found for t in face.triangles) == list(range(len(surface.triangles)))
    for face in found:
        places = surface.vertices[list(face.loop)]
        assert len(face.loop) >= 3
        assert np.ptp(places @ face.normal) < 1e-9
        assert (np.cross(np.roll(places, -1, 0) - places, np.roll(places, -2, 0) - places) @ face.normal > 0).all()
        assert normals_of(surface)[list(face.triangles)] == pytest.approx(
            np.tile(face.normal, (len(face.triangles), 1))
        )
    assert sum(area(surface, face) for face in found) == pytest.approx(
        sum(trimesh.Trimesh(surface.vertices, surface.triangles, process=False).area_faces)
    )


def test_a_flat_region_that_is_not_convex_is_cut():
    assert len(faces(el())) == 6 + 2 * 2
