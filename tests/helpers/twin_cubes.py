"""Two painted cubes, one over the other and apart.

A mesh of two parts, which a quarter turn about the vertical leaves as it is; for tests.
"""

from __future__ import annotations

import numpy as np
from made_meshes import QUADS, obj_text, split_box
from painted_cube import TILE, paint

SIDE, APART = 0.08, 0.12
"""Metres: a cube's side, and from middle to middle."""


def turned_four_times(tile):
    """(TILE, TILE, 3): its first quarter, turned into the others."""
    quarter = tile[: TILE // 2, : TILE // 2]
    above = np.concatenate([quarter, np.rot90(quarter, -1)], axis=1)
    return np.concatenate([above, np.rot90(above, 2)], axis=0)


def picture():
    """(2 * TILE, 3 * TILE, 3): tiles 0 to 2 in the lower row as painted, for sides.

    3 to 5 in the upper row with four quarters, for lids.
    """
    whole = paint().copy()
    for i in range(3):
        tile = whole[:TILE, i * TILE : (i + 1) * TILE]
        tile[:] = turned_four_times(tile.copy())
    return whole


def cubes():
    """Vertices (48, 3) m, triangles (24, 3) and uv (48, 2).

    Each cube has one tile on its four sides, and one on its two lids.
    """
    one, facets, _ = split_box()
    vertices = np.concatenate([(one - 0.5) * SIDE + [0, 0, z] for z in (0.0, APART)])
    uv = np.concatenate([_uv(one, cube) for cube in (0, 1)])
    return vertices, np.concatenate([facets, facets + len(one)]), uv


def _uv(one, cube):
    rows = []
    for i in range(len(QUADS)):
        corners = one[4 * i : 4 * i + 4] - 0.5
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        lid = abs(normal[2]) > 0.5
        sideways, upward = ([1.0, 0, 0], [0.0, 1, 0]) if lid else (np.cross([0, 0, 1], normal), [0.0, 0, 1])
        place = np.stack([corners @ sideways, corners @ upward], axis=1) + 0.5
        tile = np.array([cube, 1 if lid else 0])
        rows.append((place * (1 - 1 / TILE) + 0.5 / TILE + tile) / [3, 2])
    return np.concatenate(rows)


def write_twins(folder):
    """``twins.obj``, its MTL and its picture."""
    import cv2

    vertices, triangles, uv = cubes()
    (folder / "twins.obj").write_text(obj_text(vertices, triangles, uv, "twins.mtl"))
    (folder / "twins.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd twins.png\n")
    cv2.imwrite(str(folder / "twins.png"), picture())
    return folder / "twins.obj"
