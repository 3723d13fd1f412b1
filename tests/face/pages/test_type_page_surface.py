"""What is drawn of a surface stays small, stays whole along the texture's seams, and looks like what it is."""

from __future__ import annotations

import base64

import cv2
import numpy as np
import pytest

from plogic.face.pages.type_content import LARGEST_PICTURE, LONGEST_SIDE
from plogic.run.painted import MOST_DRAWN, Drawn, coarser, floats, shorts, texture_picture


def _picture(texture):
    return texture_picture(texture, LARGEST_PICTURE, LONGEST_SIDE)


def tube(n, *, painted):
    """A tube of 2 n² triangles whose texture has a seam: corners stand twice there."""
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1)))
    vertices = np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), v], axis=1).round(9)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + n + 1], 1), np.stack([a + 1, a + n + 2, a + n + 1], 1)])
    return Drawn(vertices, triangles, np.stack([u, v], axis=1) if painted else None)


def test_a_small_mesh_is_drawn_as_it_is():
    mesh = tube(20, painted=True)
    assert coarser(mesh) is mesh


@pytest.mark.parametrize("painted", [False, True])
@pytest.mark.parametrize("n", [110, 300])
def test_a_large_mesh_is_drawn_coarser_and_stays_round(n, painted):
    drawn = coarser(tube(n, painted=painted))
    assert 500 < len(drawn.triangles) <= MOST_DRAWN
    assert len(drawn.vertices) <= MOST_DRAWN
    assert drawn.triangles.max() == len(drawn.vertices) - 1
    assert np.abs(np.hypot(drawn.vertices[:, 0], drawn.vertices[:, 1]) - 1).max() < 0.02


def test_along_a_seam_corners_part_but_places_do_not():
    drawn = coarser(tube(200, painted=True))
    places, index = np.unique(drawn.vertices.round(9), axis=0, return_inverse=True)
    assert len(places) < len(drawn.vertices), "a seam has two corners at a place"
    stretch = np.ptp(drawn.uv[drawn.triangles][:, :, 0], axis=1)
    assert stretch.max() < 0.1, "no triangle runs across the whole texture"
    edges = np.sort(index.reshape(-1)[drawn.triangles][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    rim = [pair for pair, n in zip(*np.unique(edges, axis=0, return_counts=True), strict=True) if n == 1]
    heights = places[np.array(rim)][:, :, 2]
    assert ((heights < 0.05) | (heights > 0.95)).all(), "no crack but the tube's own two ends"


@pytest.mark.parametrize(("size", "wanted"), [((100, 300), (256, 128)), ((4096, 4096), (2048, 2048)), ((1, 1), (1, 1))])
def test_a_texture_has_powers_of_two(size, wanted):
    picture, drawn = _picture(np.full((*size, 3), 90, np.uint8))
    image = cv2.imdecode(np.frombuffer(base64.b64decode(picture["base64"]), np.uint8), cv2.IMREAD_COLOR)
    assert drawn == wanted
    assert image.shape[1::-1] == wanted


def test_a_noisy_texture_is_made_smaller_until_it_is_small_enough():
    picture, drawn = _picture(np.random.default_rng(0).integers(0, 255, (2048, 2048, 3)).astype(np.uint8))
    assert max(drawn) < 2048
    assert len(picture["base64"]) <= 4 / 3 * LARGEST_PICTURE + 4


def test_packed_numbers_come_back():
    assert np.array_equal(np.frombuffer(base64.b64decode(shorts([0, 7, 65535])), "<u2"), [0, 7, 65535])
    assert np.isfinite(np.frombuffer(base64.b64decode(floats([1e300, -1e300, 0.5])), "<f4")).all()
    with pytest.raises(ValueError, match="must be from 0 to 65535, not 0 to 65536"):
        shorts([0, 65536])
