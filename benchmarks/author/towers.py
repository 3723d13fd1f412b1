"""Write the shipped KBs of towers: ``python -m benchmarks.author.towers towers|lookalikes [FOLDER]``.

The same bytes each time.

T1 is a cuboid with a single-slope wedge top, T2 one with a pyramid; painted windows are their patches. Together they
have 1 apex, 16 corners and 95 patches, the composition that Table 1 of the paper asks for (§5.6).

The look-alikes are two towers of one shape: the ``open_tower`` has windows on all sides, the north wall of the
``blind_tower`` has none, so that from the south nothing tells which of them stands there. The ``pyramid_tower`` looks
like neither. ``plogic demo --look-again`` looks at them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.author.junctions import arms, junctions
from benchmarks.author.texture import Panel, Window, atlas, frame, indexed_png, mtl_text, obj_text
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

APPEARANCES = ("l_junction", "y_junction", "arrow_junction", "t_junction", "multi_junction", "patch")
SHARE = 0.47
"""A window's share of the pitch, each way."""
WALL, ROOF, BASE = (226, 218, 200), (206, 168, 140), (198, 198, 192)
JUNCTION_RANGE, PATCH_RANGE = "[0.3 m, 14 m]", "[0.3 m, 14 m]"
WIDE, PATCH_HALF_ANGLE = 150.0, 78.0

KB_YAML = """\
name: towers
appearance_types: [l_junction, y_junction, arrow_junction, t_junction, multi_junction, patch]
f_ref: 600
detector:
  hit: {apex: 0.95, corner: 0.8, patch: 0.95}
  clutter: {l_junction: 8, y_junction: 0.5, arrow_junction: 1, t_junction: 7, multi_junction: 1, patch: 1.5}
  sigma: 0.5
  sigmas: {apex: 0.4, corner: 0.5, patch: 0.2}
  match_tolerance: 3.0
priors: {t1: 0.5, t2: 0.5}
"""


@dataclass(frozen=True, eq=False)
class Tower:
    """``vertices`` (V, 3) m with ``names``; ``panels``.

    ``roof``: which vertices its roof part holds, ``eaves`` m up.
    """

    name: str
    vertices: Floats
    names: tuple[str, ...]
    panels: tuple[Panel, ...]
    roof: tuple[str, ...]
    eaves: float
    symmetries: str

    @property
    def surface(self) -> Surface:
        """Its closed surface, each panel cut into a fan."""
        fans = [(p.loop[0], p.loop[i], p.loop[i + 1]) for p in self.panels for i in range(1, len(p.loop) - 1)]
        return Surface(self.vertices, np.array(fans))


def t1() -> Tower:
    """0.8 × 0.6 m, 1.1 m high at x = −0.4 and 1.5 m at x = 0.4."""
    vertices = _prism(0.4, 0.3, (1.1, 1.5, 1.5, 1.1))
    walls = _walls(vertices)
    roof = Panel("roof", (4, 5, 6, 7), ROOF, _grid("roof", vertices[[4, 5, 6, 7]]))
    base = Panel("base", (3, 2, 1, 0), BASE, _quincunx(0.2, 0.15))
    tops = tuple(f"top_{corner}" for corner in CORNERS)
    names = tuple(f"base_{corner}" for corner in CORNERS) + tops
    return Tower("t1", vertices, names, (*walls, roof, base), tops, 1.1, "[]")


def t2() -> Tower:
    """0.7 × 0.7 m, walls of 1.0 m, and a pyramid whose apex is 1.5 m up; a quarter turn changes nothing."""
    vertices = np.vstack([_prism(0.35, 0.35, (1.0, 1.0, 1.0, 1.0)), [0.0, 0.0, 1.5]])
    slopes = []
    for side, loop in zip(SIDES, ((4, 5, 8), (5, 6, 8), (6, 7, 8), (7, 4, 8)), strict=True):
        across, up, _ = frame(vertices[list(loop)])
        window = Window(f"slope_{side}", vertices[list(loop)].mean(axis=0), 0.075 * across, 0.065 * up)
        slopes.append(Panel(f"slope_{side}", loop, ROOF, (window,)))
    base = Panel("base", (3, 2, 1, 0), BASE, _quincunx(0.175, 0.175))
    names = tuple(f"{level}_{corner}" for level in ("base", "eaves") for corner in CORNERS)
    panels = (*_walls(vertices), *slopes, base)
    return Tower("t2", vertices, (*names, "apex"), panels, ("apex",), 1.0, "[{axis: [0, 0, 1], fold: 4}]")


CORNERS, SIDES = ("sw", "se", "ne", "nw"), ("south", "east", "north", "west")
"""x is east, y north: the order of a prism's corners, and of its walls."""


def _prism(x: float, y: float, heights: tuple[float, ...]) -> Floats:
    ground = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return np.array([(*p, 0.0) for p in ground] + [(*p, h) for p, h in zip(ground, heights, strict=True)])


def _walls(vertices: Floats) -> list[Panel]:
    loops = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    return [Panel(s, loop, WALL, _grid(s, vertices[list(loop)])) for s, loop in zip(SIDES, loops, strict=True)]


def _grid(name: str, corners: Floats) -> tuple[Window, ...]:
    """Nine windows on a quadrilateral (4, 3), at the middles of a bilinear 3 × 3 grid, lowest row first."""
    a, b, c, d = corners
    windows = []
    for row, column in np.ndindex(3, 3):
        v, u = (2 * row + 1) / 6, (2 * column + 1) / 6
        centre = (a * (1 - u) + b * u) * (1 - v) + (d * (1 - u) + c * u) * v
        across, up = (b - a) * (1 - v) + (c - d) * v, (d - a) * (1 - u) + (c - b) * u
        windows.append(Window(f"{name}_{row}{column}", centre, SHARE * across / 6, SHARE * up / 6))
    return tuple(windows)


def _quincunx(x: float, y: float) -> tuple[Window, ...]:
    """Five windows on the base: its middle, and (± x, ± y)."""
    places = ((0.0, 0.0), (-x, -y), (x, -y), (x, y), (-x, y))
    sides = np.array([0.05, 0.0, 0.0]), np.array([0.0, 0.05, 0.0])
    names = ("middle", *CORNERS)
    return tuple(Window(f"floor_{n}", np.array([*p, 0.0]), *sides) for n, p in zip(names, places, strict=True))


def files(tower: Tower) -> dict[str, bytes]:
    """The files of a tower's folder, by name."""
    picture, uvs, palette = atlas(tower.vertices, tower.panels)
    return {
        "object.yaml": "\n".join(_object_lines(tower)).encode() + b"\n",
        "mesh.obj": obj_text(tower.vertices, tower.panels, uvs).encode(),
        "mesh.mtl": mtl_text().encode(),
        "texture.png": indexed_png(picture, palette),
    }


def _object_lines(tower: Tower) -> Iterator[str]:
    yield f"object: {tower.name}"
    yield "mesh: {file: mesh.obj, units: m}"
    yield "opaque: true"
    yield f"symmetries: {tower.symmetries}"
    yield "parts:"
    for part, foot in (("body", 0.0), ("roof", tower.eaves)):
        yield f"  - part: {part}"
        yield f"    at: {_row((0.0, 0.0, foot))}"
        yield "    features:"
        origin = np.array([0.0, 0.0, foot])
        for vertex, name in enumerate(tower.names):
            if (name in tower.roof) == (part == "roof"):
                yield from _vertex_lines(tower, vertex, origin)
        for panel in tower.panels:
            if panel.name.startswith(("roof", "slope")) == (part == "roof"):
                yield from _window_lines(panel, frame(tower.vertices[list(panel.loop)])[2], origin)


def _vertex_lines(tower: Tower, vertex: int, origin: Floats) -> Iterator[str]:
    """A corner or apex: its regions' cones, and wide lobes, for a detector loses arms and texture adds some.

    Any kind turns up anywhere.
    """
    name, surface, at = tower.names[vertex], tower.surface, tower.vertices[vertex]
    edges = arms(surface, vertex)
    yield f"      - feature: {name}"
    yield f"        type: {'apex' if name == 'apex' else 'corner'}"
    yield f"        at: {_row(at - origin)}"
    yield f"        arms: [{', '.join(_row(edge) for edge in edges)}]"
    yield "        appearances:"
    for region in junctions(surface, vertex):
        yield _appearance(region.kind, region.axis, float(np.degrees(region.half_angle)), JUNCTION_RANGE)
    outward = -edges.sum(axis=0) / np.linalg.norm(edges.sum(axis=0))
    for kind in APPEARANCES[:-1]:
        yield _appearance(kind, outward, WIDE, JUNCTION_RANGE)


def _window_lines(panel: Panel, normal: Floats, origin: Floats) -> Iterator[str]:
    for window in panel.windows:
        yield f"      - feature: {window.name}"
        yield "        type: patch"
        yield f"        at: {_row(window.centre - origin)}"
        yield "        appearances:"
        yield _appearance("patch", normal, PATCH_HALF_ANGLE, PATCH_RANGE)


def _appearance(kind: str, axis: Floats, half_angle: float, reach: str) -> str:
    angle = np.ceil(half_angle * 10) / 10
    return f"          - {{type: {kind}, lobe: {{axis: {_row(axis, 4)}, half_angle: {angle:g} deg, range: {reach}}}}}"


def _row(values: Sequence[float] | Floats, digits: int = 6) -> str:
    return "[" + ", ".join(f"{round(float(x), digits) + 0.0:.9g}" for x in values) + "]"


def write_towers(folder: Path, yaml: str, towers: Sequence[Tower]) -> None:
    """Write a KB of such towers."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "kb.yaml").write_text(yaml, encoding="utf-8")
    for tower in towers:
        place = folder / "objects" / tower.name
        place.mkdir(parents=True, exist_ok=True)
        for name, content in files(tower).items():
            (place / name).write_bytes(content)


BLIND = "north"
"""The wall without windows."""
LOOKALIKES_YAML = KB_YAML.replace("name: towers", "name: lookalikes").replace(
    "{t1: 0.5, t2: 0.5}", "{open_tower: 0.5, blind_tower: 0.5, pyramid_tower: 0.5}"
)


def look_alikes() -> tuple[Tower, ...]:
    """Return the open, the blind and the pyramid tower."""
    whole = replace(t1(), name="open_tower")
    walls = tuple(replace(panel, windows=()) if panel.name == BLIND else panel for panel in whole.panels)
    return whole, replace(whole, name="blind_tower", panels=walls), replace(t2(), name="pyramid_tower")


def author(name: str, folder: Path) -> None:
    """Write the files of the KB ``name``, towers or lookalikes, into ``folder``, over those that are there."""
    write_towers(folder, *{"towers": (KB_YAML, (t1(), t2())), "lookalikes": (LOOKALIKES_YAML, look_alikes())}[name])


if __name__ == "__main__":
    author(sys.argv[1], Path(sys.argv[2] if len(sys.argv) > 2 else f"kb/{sys.argv[1]}"))
