"""Where in space the side of an edge is: on the plane of the surface farther in, where that is a plane.

And how densely sides are looked for.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_cube import PIXELS, sizes
from random_cloud import unit
from test_sides_observed import detect, look, plate

from geometry.camera import Camera
from kb.learning.observations import ALWAYS, DENSE, FLAT, PICTURES_OF_SIDES, SPARSE, STEEP, _on_plane, _points, observed
from sensing.detectors.keypoint_detector import EdgeSides

SIZE, F = 200, 1500.0
CAMERA = Camera(SIZE, SIZE, np.array([[F, 0, 99.5], [0, F, 99.5], [0, 0, 1]]), np.zeros(0))
EDGE, BESIDE, INNER = 100.0, 101, 106
"""Columns: of a vertical edge, of what is beside it on the side of the object, and farther in. Left of the edge is the
background."""
ROWS = np.arange(20, 180, 8)
SLOPES = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))


def plane_depth(normal, level):
    """(SIZE, SIZE) of the plane normal · x = level."""
    v, u = np.mgrid[:SIZE, :SIZE]
    rays = np.dstack(
        [CAMERA.normalised(np.dstack([u, v]).reshape(-1, 2)).reshape(SIZE, SIZE, 2), np.ones((SIZE, SIZE))]
    )
    return level / (rays @ normal)


def view(depth, ledge=0.0):
    """Of a surface with an outline at the edge; beside that it is so much deeper than farther in, metres."""
    depth = depth.copy()
    depth[:, :BESIDE] = 9.0
    depth[:, BESIDE : INNER - 3] += ledge
    return SimpleNamespace(image=np.zeros((SIZE, SIZE, 3), np.uint8), depth=depth.astype(np.float32), camera=CAMERA)


def places(seen):
    ones = np.ones(len(ROWS))
    place = np.column_stack([EDGE * ones + 0.5, ROWS + 0.25])
    cell, inner = (np.column_stack([column * ones, ROWS]).astype(np.intp) for column in (BESIDE, INNER))
    return _on_plane(seen, place, cell, inner), _points(seen, place, cell), place


@settings(max_examples=50, deadline=None, derandomize=True)
@given(SLOPES, st.floats(0.5, 2.0))
def test_on_a_plane_a_place_is_where_its_ray_meets_that(slopes, level):
    """Not as deep as the picture is at the pixel beside it."""
    normal = unit(np.array([*slopes, 1.0]))
    at, beside, place = places(view(plane_depth(normal, level)))
    assert np.abs(at @ normal - level).max() < 1e-5 * level
    np.testing.assert_allclose(CAMERA.project(at), place, atol=1e-6)
    if abs(np.dot(slopes, (EDGE + 0.5 - BESIDE, 0.25))) > 0.1:  # the ray leaves the pixel beside it along the slope
        assert np.abs(beside @ normal - level).min() > 1e-5 * level


@pytest.mark.parametrize(("share", "on_plane"), [(0.5, True), (2.0, False), (-2.0, False)])
def test_where_the_surface_beside_the_edge_is_not_that_plane_it_is_as_deep_as_that(share, on_plane):
    """A step of so many times what is still flat: so many pixels."""
    normal, level = unit(np.array([0.3, 0.0, 1.0])), 1.0
    depth = plane_depth(normal, level)
    ledge = share * FLAT / F / normal[2]
    at, beside, _ = places(view(depth, ledge))
    if on_plane:
        assert np.abs(at @ normal - level).max() < 1e-5
    else:
        np.testing.assert_allclose(at, beside)


def test_of_a_surface_that_is_seen_along_itself_it_is_not_said_where_rays_meet_it():
    steep = 0.5 * STEEP
    normal = np.array([np.sqrt(1 - steep**2), 0.0, steep])
    at, beside, _ = places(view(plane_depth(normal, 0.1)))
    np.testing.assert_allclose(at, beside)


def test_sides_of_a_small_object_are_looked_for_densely_and_must_always_come_again(monkeypatch):
    """In the first picture of each size only; and where those of one picture are left out nothing is seen."""
    cells = []

    def noting(image, cell, where):
        cells.append(cell)
        return look(image, cell, where)

    def forgetting(image, cell, where):
        cells.append(cell)
        found = look(image, cell, where)
        keep = slice(0, 0 if len(cells) % PICTURES_OF_SIDES == 0 else len(found))
        return EdgeSides(found.uv[keep], found.angle[keep], found.rise[keep], found.looks[keep])

    monkeypatch.setattr("kb.learning.observations.SMALL", (PIXELS[0] + PIXELS[1]) / 2)
    with sizes():
        whole = observed(plate(), 7, detect, 0, noting)
        assert cells == [SPARSE, *[DENSE] * (PICTURES_OF_SIDES - 1), *[DENSE] * (PICTURES_OF_SIDES * (len(PIXELS) - 1))]
        less = observed(plate(), 7, detect, 0, forgetting)
    assert ALWAYS > 1 - 1 / (PICTURES_OF_SIDES - 1)  # in every other picture
    assert whole.sided.sum() > 60
    assert (whole.hit[whole.sided] >= ALWAYS).all()
    assert not less.sided.any()
