"""Procedural pictures to paint table-tops, walls and packages with: seeded, no two alike, some of them full of letters.

* ``pattern("newsprint", rng, 1024)``: (1024, 1024, 3) uint8, blue first

Packages of no known type, to stand about among the others: boxes and cans of 5 to 25 cm with text and colours on every
side.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from sensing.errors import SceneError
from sensing.simulated.body import TexturedMesh
from sensing.simulated.surroundings import noise_texture

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

CELL = 384
"""Side of one face's square in the texture, texels."""
SIDES = 32
"""Of a can's circle."""
_FACES = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7), (3, 2, 1, 0))


LETTERS = np.array(list("ABCDEFGHIJKLMNOPRSTUVWXYZaabcdeeefghiijklmnoopqrstuvwxyz0123456789"))
FONTS = (0, 2, 3, 4)
"""OpenCV's Hershey fonts without ornament: simplex, duplex, complex, triplex."""


def pattern(name: str, rng: np.random.Generator, size: int) -> NDArray[np.uint8]:
    """A (size, size, 3) uint8 picture of one kind of ``PATTERNS``; raises SceneError for another name."""
    if name not in PATTERNS:
        raise SceneError(f"pattern {name!r}: not one of {', '.join(PATTERNS)}")
    return np.clip(PATTERNS[name](rng, size), 0, 255).astype(np.uint8)


def _plain(rng: np.random.Generator, size: int) -> NDArray[np.float32]:
    """Painted or laminated: one colour with the least of grain."""
    return _tint(rng, 60, 210, 15) + rng.uniform(1, 5) * _grain(rng, size, (5, 40, size // 3))


def _noise(rng: np.random.Generator, size: int) -> NDArray[np.float32]:
    """Stone or carpet."""
    return _tint(rng, 70, 180, 15) + rng.uniform(12, 35) * _grain(rng, size, (8, 30, 110, size // 3))


def _wood(rng: np.random.Generator, size: int) -> NDArray[np.float32]:
    """Boards side by side, each with a grain along it."""
    import cv2

    picture = np.empty((size, size, 3), np.float32)
    tint = np.array([rng.uniform(0.45, 0.7), rng.uniform(0.7, 0.85), 1.0]) * rng.uniform(110, 215)
    edges = np.unique(np.r_[0, np.sort(rng.integers(size // 16, size, int(rng.integers(0, 7)))), size])
    for left, right in itertools.pairwise(edges):
        width = int(right - left)
        grain = cv2.resize(
            rng.normal(0, 1, (8, max(2, width // 2))).astype(np.float32), (width, size), interpolation=cv2.INTER_CUBIC
        )
        bend = cv2.resize(rng.normal(0, 1, (5, 3)).astype(np.float32), (width, size), interpolation=cv2.INTER_CUBIC)
        rings = np.sin(np.arange(width) * rng.uniform(0.05, 0.2) + 3 * bend)
        shade = rng.uniform(0.88, 1.08) + 0.05 * grain + 0.06 * rings
        shade[:, 0] *= 0.6
        picture[:, left:right] = tint * shade[:, :, None]
    return picture


def _checks(rng: np.random.Generator, size: int) -> NDArray[np.float32]:
    """A table cloth: squares, tiles or stripes of two colours."""
    cell = int(size // rng.integers(10, 40))
    row, column = np.indices((size, size)) // cell
    kind = int(rng.integers(3))
    chosen = ((row + column) % 2, column % 2, np.maximum(row % 2, column % 2))[kind][:, :, None]
    colours = _tint(rng, 40, 150), _tint(rng, 120, 235)
    cloth = np.where(chosen == 1, colours[0], colours[1]).astype(np.float32)
    return cloth + 4 * noise_texture(rng, (size, size), (20, size // 3))


def _newsprint(rng: np.random.Generator, size: int) -> NDArray[np.float32]:
    """Columns of small print under headlines, with pictures and rules."""
    import cv2

    page = np.empty((size, size, 3), np.float32)
    page[:] = rng.uniform(190, 225) + np.array([-14, -4, 0])
    columns = int(rng.integers(3, 6))
    gap = size // 60
    width = (size - gap) // columns - gap
    for c in range(columns):
        x, y = gap + c * (width + gap), gap
        while y < size - gap:
            part = rng.random()
            if part < 0.15:
                height = int(rng.integers(width // 3, width))
                y1 = min(y + height, size)
                page[y:y1, x : x + width] = _tint(rng, 60, 190) + 35 * noise_texture(rng, (y1 - y, width), (4, 12, 40))
            elif part < 0.35:
                height = int(rng.integers(size // 40, size // 18))
                write(page, words(rng, 2), (x, y), (width, height), int(rng.choice(FONTS)), 3, _tint(rng, 5, 60))
            else:
                height = _paragraph(page, rng, (x, y), width, size)
            y += height + gap
        cv2.line(page, (x + width + gap // 2, 0), (x + width + gap // 2, size), (70, 70, 70), 1)
    return page + 3 * noise_texture(rng, (size, size), (30, size // 3))


def _paragraph(page: NDArray[np.float32], rng: np.random.Generator, at: tuple[int, int], width: int, size: int) -> int:
    """Lines of small print from ``at`` downwards; returns their height in texels."""
    height, lines = int(rng.integers(8, 15)), int(rng.integers(4, 14))
    for i in range(lines):
        write(
            page,
            words(rng, max(2, width // (5 * height))),
            (at[0], at[1] + i * (height + 5)),
            (width, height),
            0,
            1,
            np.full(3, 45.0),
        )
    return min(lines * (height + 5), size)


def label(rng: np.random.Generator, width: int, height: int) -> NDArray[np.uint8]:
    """(height, width, 3) uint8, one face of a printed package.

    A name, fields of colour, discs, a picture, small print, a bar code.
    """
    import cv2

    ground = _tint(rng, 50, 235)
    face = np.empty((height, width, 3), np.float32)
    face[:] = ground
    side = min(width, height)
    for _ in range(int(rng.integers(1, 5))):
        x, y = int(rng.integers(width)), int(rng.integers(height))
        colour = _tint(rng, 10, 245)
        if rng.random() < 0.5:
            cv2.ellipse(
                face,
                (x, y),
                (int(rng.integers(side // 10, side // 2)), int(rng.integers(side // 12, side // 3))),
                float(rng.uniform(0, 180)),
                0,
                360,
                colour.tolist(),
                -1,
                cv2.LINE_AA,
            )
        else:
            cv2.rectangle(face, (0, y), (width, y + int(rng.integers(side // 12, side // 3))), colour.tolist(), -1)
    x, y, s = int(rng.integers(width // 2)), int(rng.integers(height // 2)), side // 3
    face[y : y + s, x : x + s] = _tint(rng, 60, 200) + 30 * noise_texture(
        rng, face[y : y + s, x : x + s].shape[:2], (3, 9, 30)
    )
    ink = _tint(rng, 0, 70) if ground.mean() > 130 else _tint(rng, 190, 255)
    big, top = int(rng.uniform(0.1, 0.22) * height), int(rng.uniform(0.05, 0.5) * height)
    write(
        face, words(rng, 1), (width // 12, top), (width * 10 // 12, big), int(rng.choice(FONTS)), max(3, big // 9), ink
    )
    for i in range(int(rng.integers(2, 7))):
        write(
            face,
            words(rng, 4),
            (width // 10, int(0.7 * height) + i * side // 20),
            (width * 6 // 10, side // 26),
            0,
            1,
            ink,
        )
    _bar_code(face, rng)
    return np.clip(face + 3 * noise_texture(rng, (height, width), (10, max(width // 3, 11))), 0, 255).astype(np.uint8)


def write(
    picture: NDArray[np.float32],
    text: str,
    at: tuple[int, int],
    size: tuple[int, int],
    font: int,
    thickness: int,
    ink: NDArray[np.float64],
) -> None:
    """Write ``text`` in a box ``size`` (width, height) with its upper left corner ``at`` (x, y), cut at the right."""
    import cv2

    base = cv2.getTextSize(text, font, 1.0, thickness)[0]
    scale = min(size[1] / max(base[1], 1), 3 * size[0] / max(base[0], 1))
    box = picture[at[1] : at[1] + size[1] + thickness + 4, at[0] : at[0] + size[0]]
    if not box.size:
        return
    canvas = np.clip(box, 0, 255).astype(np.uint8)  # putText takes bytes only
    cv2.putText(canvas, text, (0, size[1]), font, scale, ink.tolist(), thickness, cv2.LINE_AA)
    box[:] = canvas


def words(rng: np.random.Generator, number: int) -> str:
    """So many words of 3 to 8 letters of chance."""
    return " ".join("".join(rng.choice(LETTERS, int(rng.integers(3, 9)))) for _ in range(number))


def _bar_code(face: NDArray[np.float32], rng: np.random.Generator) -> None:
    height, width = face.shape[:2]
    w, h = max(width // 5, 12), max(height // 8, 8)
    x, y = width - w - 6, height - h - 6
    bars = np.repeat(rng.integers(0, 2, (w + 1) // 2), 2)[:w]
    face[y : y + h, x : x + w] = np.where(bars, 20, 240)[None, :, None]


def _tint(rng: np.random.Generator, low: float, high: float, strength: float = 45) -> NDArray[np.float64]:
    """(3,) a colour, blue first, its channels within ``strength`` of one brightness within the bounds."""
    return np.clip(rng.uniform(low, high) + rng.uniform(-strength, strength, 3), 0, 255)


def _grain(rng: np.random.Generator, size: int, cells: tuple[int, ...]) -> NDArray[np.float32]:
    """(size, size, 3) noise, nearly grey, as of stone, cloth or paint."""
    noise = noise_texture(rng, (size, size), cells)
    return np.asarray(0.2 * noise + 0.8 * noise.mean(axis=2, keepdims=True), np.float32)


PATTERNS: dict[str, Callable[[np.random.Generator, int], NDArray[np.float32]]] = {
    "plain": _plain,
    "noise": _noise,
    "wood": _wood,
    "checks": _checks,
    "newsprint": _newsprint,
    "label": lambda rng, size: label(rng, size, size).astype(np.float32),
}


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
    """(CELL, CELL, 3) the label of a face (4, 3), drawn in its own proportions: its letters are not stretched."""
    import cv2

    across, up = np.linalg.norm(corners[1] - corners[0]), np.linalg.norm(corners[3] - corners[0])
    scale = CELL / max(across, up)
    drawn = label(rng, max(64, round(across * scale)), max(64, round(up * scale)))
    return np.asarray(cv2.resize(drawn, (CELL, CELL), interpolation=cv2.INTER_LINEAR), np.uint8)
