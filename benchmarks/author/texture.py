"""Painted faces: dark windows on light walls, their atlas, and the OBJ, MTL and PNG that show them.

Vocabulary: ``Window``, a parallelogram about its ``centre``; ``Panel``, one face with its windows.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Image = NDArray[np.uint8]

DENSITY = 256.0
"""Texture pixels a metre: about 64 for the pitch of the towers' windows."""
MARGIN, FINE, LEVELS = 4, 4, 16
"""Pixels of wall round a face; samples along a pixel's side; steps from wall to window, for smooth edges."""
DARK = (52, 56, 66)
"""The windows' red, green, blue."""


@dataclass(frozen=True, eq=False)
class Window:
    """The parallelogram ``centre`` ± ``across`` ± ``up``, each (3,) m, object frame.

    Its centroid is ``centre`` exactly.
    """

    name: str
    centre: Floats
    across: Floats
    up: Floats


@dataclass(frozen=True, eq=False)
class Panel:
    """One face: ``loop`` of vertices, counterclockwise from outside, its lower edge first.

    The wall's red, green, blue; its windows.
    """

    name: str
    loop: tuple[int, ...]
    tone: tuple[int, int, int]
    windows: tuple[Window, ...]


def frame(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """Unit vectors (3,) along the lower edge of ``corners`` (n, 3), up the face, and outward."""
    across, normal = corners[1] - corners[0], np.cross(corners[1] - corners[0], corners[2] - corners[1])
    across, normal = across / np.linalg.norm(across), normal / np.linalg.norm(normal)
    return across, np.cross(normal, across), normal


def atlas(vertices: Floats, panels: Sequence[Panel]) -> tuple[Image, list[Floats], Image]:
    """Palette indices (H, W), each panel's uv (n, 2) with v upward as OBJ has it, and the palette (P, 3)."""
    cells, places, left = [], [], 0
    for number, panel in enumerate(panels):
        cell, pixels = _cell(vertices[list(panel.loop)], panel.windows)
        cells.append(cell + np.uint8(number * LEVELS))
        places.append(pixels + np.array([left, 0]))
        left += cell.shape[1]
    height, width = _even(max(len(cell) for cell in cells)), _even(left)
    picture = np.zeros((height, width), dtype=np.uint8)
    for cell, x in zip(cells, np.cumsum([0] + [cell.shape[1] for cell in cells]), strict=False):
        picture[:, x : x + cell.shape[1]] = cell[0, 0]
        picture[: len(cell), x : x + cell.shape[1]] = cell
    uvs = [np.stack([place[:, 0] / width, 1 - place[:, 1] / height], axis=1) for place in places]
    steps = np.linspace(0, 1, LEVELS)[:, None]
    palette = np.concatenate([(1 - steps) * panel.tone + steps * DARK for panel in panels]).round().astype(np.uint8)
    return picture, uvs, palette


def _even(pixels: int) -> int:
    return -(-pixels // 16) * 16


def _cell(corners: Floats, windows: Sequence[Window]) -> tuple[Image, Floats]:
    """The levels (h, w) of one face, 0 wall and LEVELS − 1 window, and its corners (n, 2): x, y in pixels, y down."""
    across, up, _ = frame(corners)
    plane = np.stack([across, -up], axis=1)  # object frame to x right, y down, m
    flat = (corners - corners[0]) @ plane
    low = flat.min(axis=0)
    width, height = np.ceil(np.ptp(flat, axis=0) * DENSITY).astype(int) + 2 * MARGIN
    x = ((np.arange(width * FINE) + 0.5) / FINE - MARGIN) / DENSITY + low[0]
    y = ((np.arange(height * FINE) + 0.5) / FINE - MARGIN) / DENSITY + low[1]
    covered = np.zeros((len(y), len(x)), dtype=bool)
    for window in windows:
        place = (window.centre - corners[0]) @ plane
        shares = np.linalg.inv(np.stack([window.across @ plane, window.up @ plane], axis=1))
        inside = [np.abs(a * (x - place[0]) + b * (y - place[1])[:, None]) <= 1 for a, b in shares]
        covered |= inside[0] & inside[1]
    share = covered.reshape(height, FINE, width, FINE).mean(axis=(1, 3))
    return np.round(share * (LEVELS - 1)).astype(np.uint8), (flat - low) * DENSITY + MARGIN


def obj_text(vertices: Floats, panels: Sequence[Panel], uvs: Sequence[Floats]) -> str:
    """The mesh: vertices shared between faces, uv not, every face cut into a fan of triangles."""
    lines = ["mtllib mesh.mtl", "usemtl painted"]
    lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in vertices]
    lines += [f"vt {u:.6f} {v:.6f}" for uv in uvs for u, v in uv]
    first = 1
    for panel in panels:
        corner = [f"{vertex + 1}/{first + i}" for i, vertex in enumerate(panel.loop)]
        lines += [f"f {corner[0]} {corner[i]} {corner[i + 1]}" for i in range(1, len(corner) - 1)]
        first += len(corner)
    return "\n".join(lines) + "\n"


def mtl_text() -> str:
    """The material: the painted texture, matt."""
    return "newmtl painted\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd texture.png\n"


def indexed_png(picture: Image, palette: Image) -> bytes:
    """A PNG of palette indices (H, W) and colours (P ≤ 256, 3): the same bytes for the same picture."""
    height, width = picture.shape
    rows = np.zeros((height, width + 1), dtype=np.uint8)  # every row begins with its filter, none
    rows[:, 1:] = picture
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    pixels = zlib.compress(rows.tobytes(), 9)
    chunks = [(b"IHDR", header), (b"PLTE", palette.tobytes()), (b"IDAT", pixels), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
