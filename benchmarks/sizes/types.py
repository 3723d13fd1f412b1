"""The knowledge bases of ``plogic bench sizes``: things of 4 cm, of 30 cm and of 5 m, as somebody writes them by hand.

Each KB has three types: blocks, prisms and L-shapes whose corners and dark marks are listed in ``object.yaml``, with
lobes that are wide and round numbers; the surface is an OBJ, painted with the marks.

* ``Outline``: a polygon seen from the south, drawn out to the north: ``Outline("wedge", ((0, 0), (9, 0), (0, 6)), 6)``
* ``write_kb("small", folder)``: the folder of a KB
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.author.texture import Panel, Window, atlas, frame, indexed_png, mtl_text, obj_text

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

JUNCTIONS = "l_junction", "y_junction", "arrow_junction", "t_junction", "multi_junction"
CORNER, MARK = "150 deg", "75 deg"
"""Half angles of lobes: a corner may look like any junction from wherever its body does not hide it."""
TONES = (226, 218, 200), (206, 168, 140), (198, 198, 192), (214, 200, 170)
"""Red, green and blue of the faces, in turn."""
KB_YAML = """\
name: {name}
appearance_types: [l_junction, y_junction, arrow_junction, t_junction, multi_junction, patch]
f_ref: 600
detector:
  hit: {{corner: 0.88, mark: 0.97}}
  clutter: {{l_junction: 7, y_junction: 0.5, arrow_junction: 1.3, t_junction: 10, multi_junction: 0.8, patch: 1.1}}
  sigma: 0.5
  match_tolerance: 3.0
"""
"""Rates are what `plogic kb learn-rates` counts in eight pictures of each (seeds from 1000, which no scene uses)."""

Place = tuple[float, float]


@dataclass(frozen=True)
class Outline:
    """A type: its ``corners`` (x, z), counter-clockwise seen from the south, and how ``deep`` it is, south to north.

    ``marks``: squares on the south face and, mirrored, on the north face (x, z); ``rows``: on the face over the edge
    from each corner to the next, shares of its length and depth. ``side`` of a mark. All lengths in one unit.
    """

    name: str
    corners: tuple[Place, ...]
    deep: float
    marks: tuple[Place, ...]
    rows: tuple[tuple[Place, ...], ...]
    side: float


ONE, PAIR, ASLANT = ((0.5, 0.5),), ((0.3, 0.5), (0.7, 0.5)), ((0.25, 0.3), (0.7, 0.7))
THREE, FOUR = ((0.25, 0.25), (0.75, 0.25), (0.5, 0.75)), ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75))
NONE: tuple[Place, ...] = ()

SMALL = (
    Outline(
        "block",
        ((0, 0), (40, 0), (40, 22), (0, 22)),
        26,
        ((8, 6), (20, 15), (33, 9)),
        (NONE, ASLANT, THREE, PAIR),
        5,
    ),
    Outline(
        "bracket",
        ((12, 12), (12, 36), (0, 36), (0, 0), (38, 0), (38, 12)),
        20,
        ((6, 6), (18, 6), (31, 6), (6, 19), (6, 30)),
        (PAIR, ONE, FOUR, NONE, ONE, PAIR),
        4,
    ),
    Outline("wedge", ((0, 0), (42, 0), (0, 26)), 30, ((6, 5), (18, 5), (7, 14)), (NONE, FOUR, ASLANT), 5),
)
"""Millimetres."""
MIDDLE = (
    Outline(
        "carton",
        ((0, 0), (30, 0), (30, 20), (0, 20)),
        16,
        ((6, 5), (15, 10), (24, 15), (24, 5)),
        (NONE, THREE, ASLANT, ONE),
        3,
    ),
    Outline(
        "step",
        ((16, 12), (16, 24), (0, 24), (0, 0), (30, 0), (30, 12)),
        20,
        ((5, 5), (15, 6), (25, 5), (5, 14), (11, 19)),
        (THREE, ASLANT, FOUR, NONE, PAIR, ONE),
        3,
    ),
    Outline(
        "ramp",
        ((0, 0), (32, 0), (32, 6), (0, 22)),
        18,
        ((5, 5), (15, 5), (26, 4), (6, 14)),
        (NONE, ONE, FOUR, THREE),
        3,
    ),
)
"""Centimetres."""
LARGE = (
    Outline(
        "house",
        ((0, 0), (5, 0), (5, 2.6), (2.5, 4.4), (0, 2.6)),
        4,
        ((1, 1), (2.5, 1.8), (4, 1), (2.5, 3.2)),
        (NONE, THREE, FOUR, ASLANT, PAIR),
        0.6,
    ),
    Outline(
        "shed",
        ((0, 0), (4.4, 0), (4.4, 2.2), (0, 3.4)),
        3,
        ((0.8, 0.9), (2.2, 1.2), (3.6, 0.9), (0.9, 2.4)),
        (NONE, PAIR, THREE, FOUR),
        0.5,
    ),
    Outline(
        "annexe",
        ((2.4, 2), (2.4, 4.6), (0, 4.6), (0, 0), (5, 0), (5, 2)),
        3,
        ((0.8, 0.9), (2.4, 1), (4, 1), (0.8, 2.4), (1.5, 3.7)),
        (PAIR, ONE, FOUR, NONE, ASLANT, THREE),
        0.5,
    ),
)
"""Metres."""
SIZES = {
    "small": (SMALL, 1e-3, "[5 cm, 50 cm]"),
    "middle": (MIDDLE, 1e-2, "[30 cm, 4 m]"),
    "large": (LARGE, 1.0, "[5 m, 50 m]"),
}
"""By the KB's name its types, metres of their unit, and the range of their lobes."""


def write_kb(name: str, folder: Path) -> None:
    """Write the folder of one of ``SIZES``."""
    outlines, unit, reach = SIZES[name]
    folder.mkdir(parents=True)
    (folder / "kb.yaml").write_text(KB_YAML.format(name=name), encoding="utf-8")
    for outline in outlines:
        place = folder / "objects" / outline.name
        place.mkdir(parents=True)
        for file, content in files(outline, unit, reach).items():
            (place / file).write_bytes(content)


def files(outline: Outline, unit: float, reach: str) -> dict[str, bytes]:
    """The files of a type's folder, by name."""
    vertices, panels = solid(outline)
    span = float(np.ptp(vertices, axis=0).max())
    picture, uvs, palette = atlas(vertices / span, [_panel_in(panel, 1.0 / span) for panel in panels])
    lines = [*_object_lines(outline.name, vertices * unit, [_panel_in(panel, unit) for panel in panels], reach)]
    return {
        "object.yaml": "\n".join(lines).encode() + b"\n",
        "mesh.obj": obj_text(vertices * unit, panels, uvs).encode(),
        "mesh.mtl": mtl_text().encode(),
        "texture.png": indexed_png(picture, palette),
    }


def solid(outline: Outline) -> tuple[Floats, list[Panel]]:
    """The corners (V, 3), and the painted faces, about the middle of the footprint; in the outline's unit."""
    x, z = np.array(outline.corners, dtype=float).T
    count, y = len(x), outline.deep / 2.0
    x = x - (x.min() + x.max()) / 2.0
    vertices = np.vstack([np.column_stack([x, np.full(count, s * y), z]) for s in (-1.0, 1.0)])
    south, north = tuple(range(count)), (count, *range(2 * count - 1, count, -1))
    shift = np.array(outline.corners).T[0] - x
    places = [(u - float(shift[0]), v) for u, v in outline.marks]
    panels = [_panel("south", south, 0, vertices, [np.array([u, -y, v]) for u, v in places], outline.side)]
    panels += [_panel("north", north, 1, vertices, [np.array([u, y, v]) for u, v in places[1:]], outline.side)]
    for i, row in enumerate(outline.rows):
        k = (i + 1) % count
        a, b, c = vertices[i], vertices[k], vertices[i + count]
        loop = (k, i, i + count, k + count)
        at = [a + s * (b - a) + t * (c - a) for s, t in row]
        panels.append(_panel(f"side{i}", loop, i + 2, vertices, at, outline.side))
    return vertices, panels


def _panel(name: str, loop: tuple[int, ...], tone: int, vertices: Floats, at: Sequence[Floats], side: float) -> Panel:
    across, up, _ = frame(vertices[list(loop)])
    half = side / 2.0
    windows = tuple(Window(f"{name}_mark{i}", place, half * across, half * up) for i, place in enumerate(at))
    return Panel(name, loop, TONES[tone % len(TONES)], windows)


def _panel_in(panel: Panel, unit: float) -> Panel:
    """The same with other lengths."""
    windows = tuple(Window(w.name, unit * w.centre, unit * w.across, unit * w.up) for w in panel.windows)
    return Panel(panel.name, panel.loop, panel.tone, windows)


def _object_lines(name: str, vertices: Floats, panels: Sequence[Panel], reach: str) -> Iterator[str]:
    yield f"object: {name}"
    yield "mesh: {file: mesh.obj, units: m}"
    yield "features:"
    for v, at in enumerate(vertices):
        normals = [frame(vertices[list(p.loop)])[2] for p in panels if v in p.loop]
        arms = [f"    arms: [{', '.join(_row(arm, 2) for arm in _arms(vertices, panels, v))}]"]
        lobe = f"half_angle: {CORNER}, range: {reach}"
        yield from _feature(f"corner{v}", "corner", at, np.sum(normals, axis=0), JUNCTIONS, lobe, arms)
    for panel in panels:
        for mark in panel.windows:
            normal = frame(vertices[list(panel.loop)])[2]
            lobe = f"half_angle: {MARK}, range: {reach}"
            yield from _feature(mark.name, "mark", mark.centre, normal, ("patch",), lobe)


def _arms(vertices: Floats, panels: Sequence[Panel], v: int) -> list[Floats]:
    """Unit directions of the edges that leave a corner."""
    ends = {
        w for p in panels for a, b in zip(p.loop, p.loop[1:] + p.loop[:1], strict=True) for w in (a, b) if v in (a, b)
    }
    return [(vertices[w] - vertices[v]) / np.linalg.norm(vertices[w] - vertices[v]) for w in sorted(ends - {v})]


def _feature(
    name: str, kind: str, at: Floats, axis: Floats, looks: Sequence[str], lobe: str, more: Sequence[str] = ()
) -> Iterator[str]:
    yield f"  - feature: {name}"
    yield f"    type: {kind}"
    yield f"    at: {_row(at, 5)}"
    yield from more
    yield "    appearances:"
    for look in looks:
        yield f"      - {{type: {look}, lobe: {{axis: {_row(axis, 2)}, {lobe}}}}}"


def _row(values: Floats, digits: int) -> str:
    return "[" + ", ".join(f"{round(float(x), digits) + 0.0:g}" for x in values) + "]"
