"""A surface that is not closed is repaired or refused as a solid (A4), never its hull, and which of these is said."""

import numpy as np
import pytest
import trimesh
from small_kb import MESH, write_small

from kb.files.read import read_kb
from kb.intake.new_type import _document, _lines
from kb.shown.cautions import cautions
from kb.surfaces.repair import Repaired
from kb.surfaces.surface import Surface


def ball():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    return np.array(mesh.vertices), np.array(mesh.faces)


def holed(places):
    vertices, triangles = ball()
    for place in places:
        top = int((vertices @ place).argmax())
        triangles = triangles[~(triangles == top).any(axis=1)]
    return Surface(vertices, triangles)


def test_small_holes_are_filled_and_counted():
    surface = holed(np.eye(3))
    assert not surface.closed
    assert surface.mended.done == "3 holes filled"
    assert surface.solid.closed
    assert surface.solid.volume == pytest.approx(Surface(*ball()).volume, rel=0.01)


@pytest.mark.parametrize("count", [1, 7, 40])
def test_facets_that_face_inward_are_turned_and_counted(count):
    vertices, triangles = ball()
    triangles[:count] = triangles[:count, ::-1]
    surface = Surface(vertices, triangles)
    assert surface.mended.done == (f"{count} facets turned over" if count > 1 else "1 facet turned over")
    assert surface.solid.volume == pytest.approx(Surface(*ball()).volume)


def test_repeated_facets_are_dropped_and_counted():
    vertices, triangles = ball()
    surface = Surface(vertices, np.concatenate([triangles, triangles[:2]]))
    assert surface.mended.done == "2 repeated facets dropped"
    assert surface.solid.closed


def test_an_open_bowl_and_a_sheet_are_refused():
    vertices, triangles = ball()
    bowl = Surface(vertices, triangles[vertices[triangles][:, :, 2].mean(axis=1) < 0.3])
    sheet = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    for surface in (bowl, sheet):
        assert surface.solid is None
        assert surface.mended.refused.startswith("1 hole is larger than 20% of it")


def test_a_closed_surface_is_its_own_solid_and_concave_it_stays():
    star = trimesh.creation.annulus(0.5, 1.0, 0.2)
    surface = Surface(np.array(star.vertices), np.array(star.faces))
    assert surface.solid is surface
    assert surface.solid.volume < 0.8 * star.convex_hull.volume


def test_kb_check_says_which(tmp_path):
    (tmp_path / "open").mkdir()
    (tmp_path / "turned").mkdir()
    kb = read_kb(write_small(tmp_path / "open", mesh=MESH.replace("f 3 1 4\n", "")))
    (said,) = [text for text in cautions(kb) if "not closed" in text]
    assert "refused as a solid" in said
    assert "A4 says nothing of it" in said
    kb = read_kb(write_small(tmp_path / "turned", mesh=MESH.replace("f 3 1 4\n", "f 3 4 1\n")))
    (said,) = [text for text in cautions(kb) if "not closed" in text]
    assert "repaired for shared volume (A4): 1 facet turned over" in said


def test_a_reason_stands_after_refused_as_a_solid_or_nothing_is_refused():
    """A small hole: what is not closed is repaired as a solid, and ``kb add`` says so, not "refused" without a why."""
    vertices, triangles = ball()
    holed = Surface(vertices, triangles[1:])
    (line,) = [line for line in _lines(document_of(holed), made(holed)) if "not closed" in line]
    assert line == "  not closed: 3 edges in one facet only; as a solid (A4) it is repaired: 1 hole filled"
    bowl = Surface(vertices, triangles[vertices[triangles][:, :, 2].mean(axis=1) < 0.3])
    (line,) = [line for line in _lines(document_of(bowl), made(bowl)) if "not closed" in line]
    assert "refused as a solid: 1 hole is larger than 20% of it, and may be meant." in line


def made(surface):
    """What ``kb add`` would have kept as it came."""
    return Repaired(surface, len(surface.vertices), len(surface.triangles), 0, 0, 0, 0, 0.0)


def document_of(surface):
    return _document("ball", made(surface), "none", {}, [], []) | {"parts": 0}


def test_a_closed_surface_that_is_not_manifold_is_called_so():
    """Two bodies that meet along an edge enclose a volume, which is not manifold."""
    square = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    one = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    other = np.array([[0, 1, 4], [0, 4, 5], [0, 5, 1], [1, 5, 4]])
    surface = Surface(square, np.concatenate([one, other])[:, ::-1])
    assert surface.closed
    said = surface.caution
    assert said == "" or said.startswith("the mesh is not manifold (1 edges in more than two facets)")
