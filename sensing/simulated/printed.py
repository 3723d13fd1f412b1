"""Packages of no known type, to stand about among the others: boxes and cans of 5 to 25 cm with text and colours on every side."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.simulated.body import TexturedMesh
from sensing.simulated.patterns import label

if TYPE_CHECKING:
    from numpy.typing import NDArray

CELL = 384
"""Side of one face's square in the texture, texels."""
SIDES = 32
"""Of a can's circle."""
_FACES = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7), (3, 2, 1, 0))


def random_package(rng: np.random.Generator) -> TexturedMesh:
    """A printed box (3 of 4) or can, origin at the centre of its base, metres."""
    if rng.random() < 0.75:
        return printed_box(rng.uniform((0.05, 0.04, 0.05), (0.17, 0.12, 0.23)), rng)
    return printed_can(float(rng.uniform(0.03, 0.05)), float(rng.uniform(0.07, 0.18)), rng)


def printed_box(size: NDArray[np.float64], rng: np.random.Generator) -> TexturedMesh:
    """A box of ``size`` (3,) metres, each of its six faces a label of its own."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    base = [(-x, -y), (x, -y), (x, y), (-x, y)]
    points = np.array([(*p, 0.0) for p in base] + [(*p, z) for p in base])
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    texture = np.concatenate([_face(points[list(face)], rng) for face in _FACES], axis=1)
    uv = np.concatenate([(square * 0.99 + 0.005 + (i, 0)) / (len(_FACES), 1) for i in range(len(_FACES))])
    triangles = np.array([(4 * i, 4 * i + j, 4 * i + j + 1) for i in range(len(_FACES)) for j in (1, 2)])
    return TexturedMesh(points[np.array(_FACES).reshape(-1)], triangles, uv, texture)


def printed_can(radius: float, height: float, rng: np.random.Generator) -> TexturedMesh:
    """A cylinder of metres: a label around it, lids of metal; its texture is the label over a strip for the lids."""
    around = np.linspace(0, 2 * np.pi, SIDES + 1)
    ring = np.stack([radius * np.cos(around), radius * np.sin(around)], axis=1)
    wall = np.concatenate([np.c_[ring, np.zeros(SIDES + 1)], np.c_[ring, np.full(SIDES + 1, height)]])
    wall_uv = np.concatenate([np.c_[around / (2 * np.pi), np.full(SIDES + 1, v)] for v in (0.27, 0.995)])
    n = SIDES + 1
    triangles = [t for i in range(SIDES) for t in ((i, i + 1, n + i + 1), (i, n + i + 1, n + i))]
    triangles += [(2 * n, 2 * n + 1 + (i + 1) % n, 2 * n + 1 + i) for i in range(SIDES)]
    triangles += [(3 * n + 1, 3 * n + 2 + i, 3 * n + 2 + (i + 1) % n) for i in range(SIDES)]
    lids = [np.r_[[(0.0, 0.0, z)], np.c_[ring, np.full(n, z)]] for z in (0.0, height)]
    lid_uv = np.tile(np.r_[[(0.0, 0.0)], ring / radius] * 0.1 + (0.5, 0.12), (2, 1))
    strip = np.clip(rng.uniform(140, 210) + rng.normal(0, 6, (CELL // 3, 2 * CELL, 3)), 0, 255).astype(np.uint8)
    texture = np.concatenate([label(rng, 2 * CELL, CELL), strip])
    return TexturedMesh(np.concatenate([wall, *lids]), np.array(triangles), np.concatenate([wall_uv, lid_uv]), texture)


def _face(corners: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.uint8]:
    """(CELL, CELL, 3) the label of a face (4, 3), drawn in its own proportions, so that its letters are not stretched."""
    import cv2

    across, up = np.linalg.norm(corners[1] - corners[0]), np.linalg.norm(corners[3] - corners[0])
    scale = CELL / max(across, up)
    drawn = label(rng, max(64, round(across * scale)), max(64, round(up * scale)))
    return np.asarray(cv2.resize(drawn, (CELL, CELL), interpolation=cv2.INTER_LINEAR), np.uint8)
