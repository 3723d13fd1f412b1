"""A knowledge base of one book: its letters, the most distinctive features, are on its front alone."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

KB = """\
name: library
appearance_types: [letter, corner]
f_ref: 600
detector: {hit: {letter: 0.9, corner: 0.9}, clutter: {letter: 2, corner: 4}, sigma: 1.0, match_tolerance: 5}
"""
HALF = 0.08, 0.02, 0.12
"""Half its width, thickness and height, m."""
LETTERS = (-0.05, 0.04), (0.02, 0.07), (0.055, -0.03), (-0.03, -0.08)
MARKS = (-0.05, 0.05), (0.03, 0.06), (0.05, -0.05), (-0.02, -0.07), (0.06, 0.01), (-0.06, -0.02)
"""On the front, y < 0, and on the back: x and z, m."""
QUADS = (1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)


def write_book(folder: Path) -> Path:
    """The folder: four letters on the front, six marks that look like corners on the back, and eight corners."""
    corners = list(product((-1, 1), repeat=3))
    rows = [_feature(f"letter_{i}", "letter", (x, -HALF[1], z), (0, -1, 0), 70) for i, (x, z) in enumerate(LETTERS)]
    rows += [_feature(f"mark_{i}", "corner", (x, HALF[1], z), (0, 1, 0), 70) for i, (x, z) in enumerate(MARKS)]
    rows += [_feature(f"corner_{i}", "corner", _at(sides), sides, 100) for i, sides in enumerate(corners)]
    home = folder / "objects/book"
    home.mkdir(parents=True)
    (folder / "kb.yaml").write_text(KB)
    head = "object: book\nmesh: {file: mesh.obj, units: m}\nopaque: true\nfeatures:\n"
    (home / "object.yaml").write_text(head + "".join(rows))
    points = "".join("v {} {} {}\n".format(*_at(sides)) for sides in corners)
    facets = "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in QUADS)
    (home / "mesh.obj").write_text(points + facets)
    return folder


def _at(sides: tuple[int, ...]) -> tuple[float, ...]:
    return tuple(side * half for side, half in zip(sides, HALF, strict=True))


def _feature(name: str, kind: str, at: tuple[float, ...], axis: tuple[int, ...], half_angle: int) -> str:
    return (
        f"  - feature: {name}\n    type: {kind}\n    at: {list(at)}\n    appearances:\n"
        f"      - {{type: {kind}, lobe: {{axis: {list(axis)}, half_angle: {half_angle} deg, range: [0.2 m, 5 m]}}}}\n"
    )
