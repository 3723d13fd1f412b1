"""What an interpretation carries to be looked at stays small, and looks like what it is."""

from __future__ import annotations

import base64
from types import SimpleNamespace

import numpy as np
import pytest

from plogic.run.carried import LARGEST_PNG, MOST_TRIANGLES, image_asset, mesh_assets
from plogic.run.painted import _coloured


def _sheet(n):
    """A square of n by n by 2 triangles, 1 m a side, bent into a half pipe."""
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    vertices = np.stack([u, v, np.sin(np.pi * u)], -1).reshape(-1, 3)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    return vertices, np.concatenate([np.stack([a, a + 1, a + n + 1], 1), np.stack([a + 1, a + n + 2, a + n + 1], 1)])


def _carried(vertices, triangles):
    surface = SimpleNamespace(vertices=vertices, triangles=triangles)
    mesh = mesh_assets({"pipe": SimpleNamespace(surface=surface)})["meshes"]["pipe"]
    return np.array(mesh["vertices"]), np.array(mesh["triangles"])


def test_a_small_mesh_is_carried_as_it_is():
    vertices, triangles = _sheet(10)
    assert np.abs(_carried(vertices, triangles)[0] - vertices).max() <= 5e-5
    assert np.array_equal(_carried(vertices, triangles)[1], triangles)


@pytest.mark.parametrize("n", [60, 300])
def test_a_large_mesh_is_carried_coarser_and_stays_hollow(n):
    vertices, triangles = _carried(*_sheet(n))
    assert 200 < len(triangles) <= MOST_TRIANGLES
    assert triangles.max() < len(vertices)
    assert np.abs(vertices[:, 2] - np.sin(np.pi * vertices[:, 0])).max() < 0.05
    assert np.ptp(vertices, axis=0).min() > 0.9


def test_a_noisy_picture_is_carried_as_jpeg_a_plain_one_as_png():
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    assert image_asset(noise)["image"]["media_type"] == "image/jpeg"
    assert image_asset(noise // 255)["image"]["media_type"] == "image/png"
    assert len(image_asset(noise)["image"]["base64"]) < 4 / 3 * LARGEST_PNG


def test_a_texture_of_a_piece_a_triangle_is_carried_as_colours_of_vertices():
    vertices, triangles = _sheet(20)
    split = vertices[triangles].reshape(-1, 3)
    column = np.repeat(np.arange(len(triangles)), 3)
    uv = np.column_stack([(column + 0.5) / len(triangles), np.full(len(split), 0.5)])
    texture = np.zeros((4, len(triangles), 3), np.uint8)
    texture[..., 2] = 255 * split.reshape(-1, 3, 3).mean(axis=1)[:, 0]  # red grows to the right
    row = _coloured(split, np.arange(len(split)).reshape(-1, 3), uv, texture)
    at = np.frombuffer(base64.b64decode(row["vertices"]), "<f4").reshape(-1, 3)
    colours = np.frombuffer(base64.b64decode(row["colours"]), np.uint8).reshape(-1, 3)
    assert len(at) == len(vertices)
    assert np.abs(colours[:, 0] / 255 - at[:, 0]).max() < 0.05
    assert not colours[:, 1:].any()
    assert len(np.frombuffer(base64.b64decode(row["triangles"]), "<u2")) == triangles.size
