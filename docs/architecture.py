"""The floors and rooms of the code and what imports what at run time: read from the source, drawn, and listed.

A *room* is a package (a folder with ``__init__.py``), or ``cli``. A *floor* is a top-level package, or a package of
``plogic``, with the rooms in it.
A *run-time import* is any import but those for the type checker alone, at the top of a file or in a function, and any
module named in a string.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

import ast
from functools import cache
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import networkx as nx

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("geometry", "kb", "sensing", "plogic")
FLOORS = (
    "geometry",
    "kb",
    "sensing",
    "plogic.base",
    "plogic.measures",
    "plogic.inference",
    "plogic.logic",
    "plogic.facts",
    "plogic.scene",
    "plogic.match",
    "plogic.cycle",
    "plogic.sequence",
    "plogic.rates",
    "plogic.run",
    "plogic.face",
    "plogic",
    "cli",
)
"""Lowest first: each floor imports only those before it."""
HEAD = "# Floors and rooms\n\nWritten by `python docs/generate.py` from the imports of the code. Do not edit."
LEAD = """![Floors, rooms and run-time imports](architecture.svg)

Each floor imports only those below it, and no room imports itself through others: `tests/test_floors.py` holds the code to it.
Imports inside functions count; imports for the type checker alone do not. In the drawing, arrows point down, or to the left within a floor,
and an arrow that follows from others is left out. The table has the highest floor first."""


# -- the imports, read from the source ---------------------------------------------------------------------------------


@cache
def modules() -> dict[str, Path]:
    """Every installed module by its dotted name, packages among them."""
    files = [ROOT / "cli.py", *(file for top in PACKAGES for file in sorted((ROOT / top).rglob("*.py")))]
    return {".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file for file in files}


def room_of(module: str) -> str:
    """The room that a module stands in: a package's ``__init__`` stands in the package."""
    path = modules()[module]
    return module if path.name == "__init__.py" or module == "cli" else module.rpartition(".")[0]


def floor_of(room: str) -> str:
    """The floor that a room, or a module, stands on."""
    return ".".join(room.split(".")[: 2 if room.startswith("plogic.") else 1])


def statements(path: Path) -> Iterator[ast.AST]:
    """Every node of a file that may run: bodies of ``if TYPE_CHECKING`` are left out."""
    todo: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while todo:
        node = todo.pop()
        yield node
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            todo += node.orelse
        else:
            todo += ast.iter_child_nodes(node)


def _named(node: ast.AST) -> list[str]:
    """The dotted names that an import, or a string, names."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        inside = [f"{node.module}.{alias.name}" for alias in node.names]
        return [name if name in modules() else str(node.module) for name in inside]
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and "." in node.value:
        return [node.value.partition(":")[0]]
    return []


@cache
def imports() -> tuple[tuple[str, int, str], ...]:
    """(module, line, imported module) of every run-time import between installed modules."""
    return tuple(
        (module, getattr(node, "lineno", 0), name)
        for module, path in modules().items()
        for node in statements(path)
        for name in _named(node)
        if name in modules() and name != module
    )


@cache
def rooms() -> nx.DiGraph:
    """The rooms that hold code, and an edge from each to every other that it imports."""
    graph = nx.DiGraph()
    graph.add_nodes_from(sorted({room_of(module) for module, path in modules().items() if _has_code(path)}))
    pairs = {(room_of(module), room_of(name)) for module, _, name in imports()}
    graph.add_edges_from(sorted((room, other) for room, other in pairs if room != other))
    return graph


def _has_code(path: Path) -> bool:
    return path.name != "__init__.py" or len(ast.parse(path.read_text(encoding="utf-8")).body) > 1


def idea(room: str) -> str:
    """The first sentence of a room's docstring."""
    text = ast.get_docstring(ast.parse(modules()[room].read_text(encoding="utf-8"))) or ""
    return " ".join(text.partition("\n\n")[0].split()).rstrip(".")


# -- the page ----------------------------------------------------------------------------------------------------------


def page() -> str:
    """The text of docs/architecture.md."""
    rows = [row for floor in reversed(FLOORS) for row in _rows(floor)]
    table = "\n".join(["| floor | room | its idea | imports |", "|---|---|---|---|", *rows])
    return f"{HEAD}\n\n{LEAD}\n\n{table}\n"


def _rows(floor: str) -> list[str]:
    """The table's rows of a floor: one for the floor, one for each of its rooms."""
    inside = [room for room in modules() if floor_of(room) == floor and room_of(room) == room]
    shown = [room for room in inside if room == floor or room in rooms()]
    names = [(f"`{floor}`", "") if room == floor else ("", f"`{_short(room)}`") for room in shown]
    return [
        f"| {left} | {right} | {idea(room)} | {_below(room)} |"
        for (left, right), room in zip(names, shown, strict=True)
    ]


def _below(room: str) -> str:
    """The rooms of its own floor, and the floors below, that a room imports."""
    if room not in rooms():
        return ""
    names = {_short(other) if floor_of(other) == floor_of(room) else floor_of(other) for other in rooms()[room]}
    return ", ".join(sorted(name.removeprefix("plogic.") for name in names))


def _short(room: str) -> str:
    return room.rpartition(".")[2]


# -- the drawing -------------------------------------------------------------------------------------------------------

LEFT, BOX, GAP, HIGH, ROW, LANE = 110, 116, 44, 30, 78, 7
"""Pixels: the column of floors' names, a box's width, the gap between boxes, a box's height, a row's height, and
between two lines in one gap."""
PALETTE = ("#1b6ca8", "#b5541c", "#2f7d32", "#8e3a8e", "#a3262a", "#4d5b9e", "#7a6a12", "#11777c")
Point = tuple[float, float]
Edge = tuple[str, str]


def drawing() -> str:
    """The text of docs/architecture.svg."""
    graph = nx.transitive_reduction(rooms())
    rows = [row for floor in FLOORS if (row := _row(floor))]
    place = {room: (k, i) for k, row in enumerate(rows) for i, room in enumerate(row)}
    wide = LEFT + max(len(row) for row in rows) * (BOX + GAP) + 110
    high = len(rows) * ROW + 20
    lines = [_line(edge, place, points) for edge, points in _routes(graph, rows, place).items()]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" '
        'font-family="sans-serif" font-size="13">'
    )
    return "\n".join(
        [
            head,
            "<title>Floors, rooms and run-time imports</title>",
            f'<rect width="{wide}" height="{high}" fill="#ffffff"/>',
            *[_band(row, k, len(rows), wide) for k, row in enumerate(rows)],
            *lines,
            *[_box(room, place, len(rows)) for room in place],
            "</svg>\n",
        ]
    )


def _row(floor: str) -> list[str]:
    """A floor's rooms, each to the right of those that it imports."""
    graph = rooms()
    inside = graph.subgraph([room for room in graph if floor_of(room) == floor])
    return list(reversed(list(nx.lexicographical_topological_sort(inside))))


def _top(row: int, count: int) -> float:
    return 10 + (count - 1 - row) * ROW + (ROW - HIGH) / 2


def _band(row: list[str], k: int, count: int, wide: int) -> str:
    floor = floor_of(row[0])
    y = _top(k, count) - (ROW - HIGH) / 2
    return (
        f'<rect x="0" y="{y:g}" width="{wide}" height="{ROW}" fill="{("#f4f6f8", "#e9edf1")[k % 2]}"/>'
        f'<text x="12" y="{y + ROW / 2 + 5:g}" font-weight="bold">{escape(floor.removeprefix("plogic."))}'
        f"<title>{escape(idea(floor))}</title></text>"
    )


def _box(room: str, place: dict[str, tuple[int, int]], count: int) -> str:
    k, i = place[room]
    x, y = LEFT + i * (BOX + GAP), _top(k, count)
    return (
        f'<g><title>{escape(idea(room))}</title><rect x="{x}" y="{y:g}" width="{BOX}" height="{HIGH}" rx="5" fill="#ffffff" '
        f'stroke="{PALETTE[k % len(PALETTE)]}" stroke-width="1.5"/>'
        f'<text x="{x + BOX / 2:g}" y="{y + 20:g}" text-anchor="middle">{escape(_short(room))}</text></g>'
    )


def _routes(graph: nx.DiGraph, rows: list[list[str]], place: dict[str, tuple[int, int]]) -> dict[Edge, list[Point]]:
    """The points of each arrow: it leaves a box below, passes the rows between in gaps, and enters a box from above.

    Within a row it goes left.
    """
    count = len(rows)
    routes = {
        (room, other): _within(place[room][1], place[other][1], _top(place[room][0], count))
        for room, other in graph.edges
        if place[room][0] == place[other][0]
    }
    ports = _ports(sorted(edge for edge in graph.edges if edge not in routes), place)
    middle: dict[Edge, list[Point]] = {edge: [] for edge in ports}
    for row in range(count - 2, 0, -1):
        passing = {edge: ends for edge, ends in ports.items() if place[edge[0]][0] > row > place[edge[1]][0]}
        for edge, x in _lanes(passing, len(rows[row])).items():
            middle[edge] += [(x, _top(row, count) - 4), (x, _top(row, count) + HIGH + 4)]
    for edge, (x0, x1) in ports.items():
        (k, _), (low, _) = place[edge[0]], place[edge[1]]
        routes[edge] = [(x0, _top(k, count) + HIGH), *middle[edge], (x1, _top(low, count))]
    return dict(sorted(routes.items()))


def _ports(edges: list[Edge], place: dict[str, tuple[int, int]]) -> dict[Edge, Point]:
    """Where each arrow leaves and enters, in x: those of one box side by side, in the order of their other ends."""
    ends = {edge: [0.0, 0.0] for edge in edges}
    for end in (0, 1):
        for room in sorted({edge[end] for edge in edges}):
            mine = sorted(
                (edge for edge in edges if edge[end] == room), key=lambda edge: (place[edge[1 - end]][1], edge)
            )
            for n, edge in enumerate(mine, start=1):
                ends[edge][end] = LEFT + place[room][1] * (BOX + GAP) + BOX * n / (len(mine) + 1)
    return {edge: (x0, x1) for edge, (x0, x1) in ends.items()}


def _lanes(passing: dict[Edge, Point], boxes: int) -> dict[Edge, float]:
    """Where each arrow passes a row, in x: in the gap nearest to its way that still has room.

    The last gap is as wide as need be.
    """
    wanted = sorted(passing, key=lambda edge: (sum(passing[edge]), edge))
    gaps: list[list[Edge]] = [[] for _ in range(boxes)]
    for edge in wanted:
        near = (sum(passing[edge]) / 2 - LEFT + GAP / 2) / (BOX + GAP) - 1
        free = [n for n in range(boxes) if n == boxes - 1 or len(gaps[n]) < GAP // LANE - 1]
        gaps[min(free, key=lambda n: (abs(n - near), n))].append(edge)
    left = [LEFT + (n + 1) * (BOX + GAP) - GAP + LANE for n in range(boxes)]
    return {edge: left[n] + i * LANE for n, gap in enumerate(gaps) for i, edge in enumerate(gap)}


def _within(i: int, j: int, top: float) -> list[Point]:
    """An arrow between two rooms of one row: straight to the neighbour, else below the boxes between."""
    right, left = LEFT + i * (BOX + GAP), LEFT + j * (BOX + GAP) + BOX
    if i == j + 1:
        return [(right, top + HIGH / 2), (left, top + HIGH / 2)]
    below = top + HIGH + 5 + 3 * (i - j)
    return [(right + 8, top + HIGH), (right - 8, below), (left, below), (left - 10, top + HIGH)]


def _line(edge: Edge, place: dict[str, tuple[int, int]], points: list[Point]) -> str:
    """One arrow as a path: straight where a row is passed, curved between rows."""
    (x, y), *rest = points
    path = f"M{x:.4g} {y:.4g}"
    same_row = place[edge[0]][0] == place[edge[1]][0]
    for (x0, y0), (x1, y1) in pairwise(points):
        curve = f"C{x0:.4g} {(y0 + y1) / 2:.4g} {x1:.4g} {(y0 + y1) / 2:.4g} "
        path += f"{'L' if same_row or x0 == x1 else curve}{x1:.4g} {y1:.4g}"
    colour = PALETTE[place[edge[0]][0] % len(PALETTE)]
    (x0, y0), (x1, y1) = rest[-2] if len(rest) > 1 else (x, y), rest[-1]
    head = _head(x1, y1, sideways=same_row and y0 == y1, up=y1 < y0)
    title = escape(f"{edge[0]} imports {edge[1]}")
    return f'<g><title>{title}</title><path d="{path}" fill="none" stroke="{colour}" stroke-width="1.2"/><path d="{head}" fill="{colour}"/></g>'


def _head(x: float, y: float, *, sideways: bool, up: bool) -> str:
    """A triangle of 7 pixels whose tip is at (x, y)."""
    if sideways:
        return f"M{x:.4g} {y:.4g}l7 -3.5v7z"
    return f"M{x:.4g} {y:.4g}l-3.5 {7 if up else -7}h7z"
