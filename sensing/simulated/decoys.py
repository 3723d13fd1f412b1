"""Untyped things to stand about: boxes and wedges of random sizes, plain or painted with random rectangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.simulated.body import TexturedMesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

CELL = 192
"""Side of one face's square in the texture, texels."""
_BOX = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7), (3, 2, 1, 0))
_WEDGE = ((0, 1, 4), (1, 2, 5, 4), (2, 3, 5), (3, 0, 4, 5), (3, 2, 1, 0))


def random_decoy(rng: np.random.Generator) -> TexturedMesh:
    """A box or a wedge, 0.3 to 1.2 m a side, origin at the centre of its base, painted with probability 1/2."""
    size = rng.uniform((0.3, 0.3, 0.3), (0.9, 0.9, 1.2))
    painted = bool(rng.random() < 0.5)
    return box(size, rng, painted=painted) if rng.random() < 0.5 else wedge(size, rng, painted=painted)


def box(size: NDArray[np.float64], rng: np.random.Generator, *, painted: bool) -> TexturedMesh:
    """A box of ``size`` (3,) metres; a wall colour of chance, with random rectangles if ``painted``."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    base = [(-x, -y), (x, -y), (x, y), (-x, y)]
    points: list[tuple[float, ...]] = [(*p, 0.0) for p in base] + [(*p, z) for p in base]
    return _painted(points, _BOX, rng, painted=painted)


def wedge(size: NDArray[np.float64], rng: np.random.Generator, *, painted: bool) -> TexturedMesh:
    """A ramp of ``size`` (3,) metres: a right-angled triangle along x, as wide as y."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    points: list[tuple[float, ...]] = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0), (-x, -y, z), (-x, y, z)]
    return _painted(points, _WEDGE, rng, painted=painted)


def _painted(
    points: list[tuple[float, ...]], faces: tuple[tuple[int, ...], ...], rng: np.random.Generator, *, painted: bool
) -> TexturedMesh:
    wall = rng.uniform(110, 230) + rng.uniform(-20, 20, 3)
    texture = np.empty((CELL, CELL * len(faces), 3), np.uint8)
    texture[:] = np.clip(wall, 0, 255).astype(np.uint8)
    square = np.array([(0.02, 0.02), (0.98, 0.02), (0.98, 0.98), (0.02, 0.98)])
    vertices: list[tuple[float, ...]] = []
    uv: list[tuple[float, float]] = []
    triangles: list[tuple[int, int, int]] = []
    for i, face in enumerate(faces):
        start = len(vertices)
        vertices += [points[k] for k in face]
        uv += [((i + float(s)) / len(faces), float(t)) for s, t in square[: len(face)]]
        triangles += [(start, start + j, start + j + 1) for j in range(1, len(face) - 1)]
        if painted:
            _paint(texture[:, i * CELL : (i + 1) * CELL], rng)
    return TexturedMesh(np.array(vertices), np.array(triangles), np.array(uv), texture)


def _paint(cell: NDArray[np.uint8], rng: np.random.Generator) -> None:
    """One to six rectangles of any brightness, anywhere inside the face; they may overlap."""
    for _ in range(int(rng.integers(1, 7))):
        width, height = rng.integers(CELL // 12, CELL // 3, 2)
        left, top = rng.integers(8, CELL - 8 - width), rng.integers(8, CELL - 8 - height)
        cell[top : top + height, left : left + width] = np.clip(rng.uniform(20, 240) + rng.uniform(-15, 15, 3), 0, 255)
