"""Surfaces: closed, manifold, welded along seams (§2.8)."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.author.towers import author, t1, t2
from kb.errors import SurfaceError
from kb.surfaces.surface import Surface, surface_from_mesh, welded

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACETS = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def obj(path: Path, vertices, triangles) -> Path:
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_tetrahedron_has_its_volume_diameter_and_centre():
    surface = Surface(CORNERS, FACETS)
    assert surface.faults == ""
    assert surface.volume == pytest.approx(1 / 6)
    assert surface.diameter == pytest.approx(np.sqrt(3))
    assert surface.centre == pytest.approx([0.5, 0.5, 0.5])
    assert surface.rays.first_hit([[0.1, 0.1, 5]], [[0, 0, -1]])[0] == pytest.approx(4.2)


def test_arrays_are_read_only():
    surface = Surface(CORNERS, FACETS)
    for array in (surface.vertices, surface.triangles, surface.centre):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("triangles", "fault"),
    [
        (FACETS[:3], "3 edges in one facet only"),
        (np.vstack([FACETS, FACETS[:1]]), "3 edges in more than two facets"),
        (np.vstack([FACETS[:3], FACETS[3:, ::-1]]), "3 edges whose two facets face opposite ways"),
    ],
)
def test_an_open_surface_is_refused_with_counts(triangles, fault):
    assert fault in Surface(CORNERS, triangles).faults


def test_collinear_facets_are_refused_and_dropped_by_welding():
    vertices = np.vstack([CORNERS, [0.5, 0, 0]])
    triangles = np.vstack([FACETS, [[0, 4, 1]]])
    assert "1 degenerate facets" in Surface(vertices, triangles).faults
    assert welded(vertices, triangles).faults == ""


def test_welding_mends_seams():
    split = CORNERS[FACETS].reshape(-1, 3)
    surface = welded(split, np.arange(12).reshape(4, 3))
    assert surface.faults == ""
    assert surface.vertices.shape == (4, 3)


def test_a_mesh_file_is_scaled_and_turned_outward(tmp_path):
    surface = surface_from_mesh(obj(tmp_path / "in.obj", CORNERS * 1000, FACETS[:, ::-1]), 0.001)
    assert surface.volume == pytest.approx(1 / 6)


@pytest.mark.parametrize("text", ["", "v 0 0 0\n", "nonsense"])
def test_no_mesh_is_a_surface_error(tmp_path, text):
    path = tmp_path / "bad.obj"
    path.write_text(text)
    with pytest.raises(SurfaceError):
        surface_from_mesh(path)


def test_coordinates_that_are_not_finite_are_a_surface_error():
    vertices = CORNERS.copy()
    vertices[0, 0] = np.nan
    with pytest.raises(SurfaceError, match="finite"):
        Surface(vertices, FACETS)


@pytest.mark.parametrize(("tower", "volume"), [(t1(), 0.8 * 0.6 * 1.3), (t2(), 0.49 * (1 + 0.5 / 3))])
def test_the_towers_meshes_are_their_surfaces(tmp_path, tower, volume):
    author("towers", tmp_path)
    surface = surface_from_mesh(tmp_path / "objects" / tower.name / "mesh.obj")
    assert len(surface.vertices) == len(tower.vertices)
    assert surface.volume == pytest.approx(volume)
    assert tower.surface.volume == pytest.approx(volume)
