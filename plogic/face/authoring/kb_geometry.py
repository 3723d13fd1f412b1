"""``plogic kb show --geometry``: mereology, faces, vector pencils and convergence (§2.5, §2.7, §2.8, §6.3).

Vocabulary, each with an example value:

* a part, ``{"part": "roof", "proper_part_of": [""], "discrete_from": ["body"], "features": 1}``; "" is the whole
* a face, ``{"corners": 4, "normal": [0, 0, 1], "area": 0.48, "facets": 2}``
* a pencil, the lines of sight from one feature to its viewpoints: ``{"feature": "apex", "lobes": 9, "seen": 0.8}``,
  ``seen`` its share of ``CELLS`` directions
* a set of four that converges: some lobes of all four hold one viewpoint, from which the type itself hides none of them
"""

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import networkx as nx
import numpy as np

from geometry.arrays import Floats
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.surfaces.faces import faces
from plogic.face.shown.tables import plain_table
from plogic.match.hand.view_cells import CELLS, ViewCells, view_cells
from plogic.measures.distinctiveness import distinctiveness, instance_counts

SHOWN = 12
"""Rows of a table for people; the document has all."""
SETS = 3
"""Sets of four that are told, the most distinctive first."""
FLAT = 0.01
"""Four places are coplanar where they span less than this share of their extent cubed: POSIT wants a volume (§6.1)."""


def geometry_text(kb: KnowledgeBase, types: tuple[ObjectType, ...]) -> str:
    """The tables of these types, at most ``SHOWN`` rows each."""
    return "\n".join(line for row in geometry_rows(kb, types) for line in _tables(row))


def geometry_rows(kb: KnowledgeBase, types: tuple[ObjectType, ...]) -> list[dict[str, Any]]:
    """A row each type: its ``parts``, ``faces``, ``pencils`` and ``convergence``."""
    dv = distinctiveness(instance_counts(kb.types))
    return [_row(kind, dv) for kind in types]


def _row(kind: ObjectType, dv: dict[str, float]) -> dict[str, Any]:
    cells = view_cells(kind) if kind.seen_features else None
    return {
        "type": kind.name,
        "parts": list(_parts(kind)),
        "faces": list(_faces(kind)),
        "pencils": [] if cells is None else list(_pencils(kind, cells)),
        "convergence": [] if cells is None else _convergence(kind, cells, dv),
    }


def _parts(kind: ObjectType) -> Iterator[dict[str, Any]]:
    """Objects and features below the whole, compounds' members too; appearances are no parts (A3)."""
    nodes = [name for name, node in kind.tree.nodes.items() if node.kind != "appearance"]
    tree = kind.tree.graph.subgraph(nodes)
    below = {node: nx.descendants(tree, node) for node in nodes}
    some = [node for node in nodes if node and (tree.nodes[node]["kind"] == "object" or below[node])]
    for node in some:
        above = [other for other in nodes if node in below[other]]
        apart = [other for other in some if other != node and other not in above and other not in below[node]]
        number = sum(tree.nodes[other]["kind"] == "feature" for other in below[node])
        yield {"part": node, "proper_part_of": above, "discrete_from": apart, "features": number}


def _faces(kind: ObjectType) -> Iterator[dict[str, Any]]:
    surface = kind.surface
    if surface is None or surface.faults:
        return
    for face in faces(surface):
        places = surface.vertices[list(face.loop)]
        across = np.cross(places[1:-1] - places[0], places[2:] - places[0]).sum(axis=0)
        normal = [round(float(value) + 0.0, 6) for value in face.normal]
        area = round(float(across @ face.normal) / 2.0, 9)
        yield {"corners": len(face.loop), "normal": normal, "area": area, "facets": len(face.triangles)}


def _pencils(kind: ObjectType, cells: ViewCells) -> Iterator[dict[str, Any]]:
    table, seen = kind.lobes, cells.visible.mean(axis=0)
    number = np.bincount(table.feature, minlength=table.features)
    for f, feature in enumerate(kind.seen_features):
        mine = table.feature == f
        if not mine.any():
            continue
        yield {
            "feature": feature.name,
            "type": feature.type,
            "lobes": int(number[f]),
            "widest": float(np.arccos(table.cos_half[mine].min())),
            "range": [float(table.r_min[mine].min()), float(table.r_max[mine].max())],
            "seen": float(seen[f]),
        }


def _convergence(kind: ObjectType, cells: ViewCells, dv: dict[str, float]) -> list[dict[str, Any]]:
    """The ``SETS`` most distinctive sets of four that one viewpoint sees, not coplanar, with such a viewpoint."""
    features = kind.seen_features
    weight, at = np.array([dv[f.type] for f in features]), np.array([f.at for f in features])
    order = np.argsort(-weight, kind="stable")
    found: dict[tuple[int, ...], int] = {}
    for cell, visible in enumerate(cells.visible):
        best = next((four for four in combinations(order[visible[order]][:SHOWN], 4) if _spans(at[list(four)])), None)
        if best is not None:
            found.setdefault(tuple(int(f) for f in best), cell)
    ranked = sorted(found, key=lambda four: (-weight[list(four)].sum(), four))[:SETS]
    return [
        {
            "features": [features[f].name for f in four],
            "dv": float(weight[list(four)].sum()),
            "viewpoint": cells.directions[found[four]].round(6).tolist(),
        }
        for four in ranked
    ]


def _spans(four: Floats) -> bool:
    """Whether four places (4, 3) are not coplanar."""
    sides = four[1:] - four[0]
    return bool(abs(np.linalg.det(sides)) > FLAT * np.linalg.norm(np.ptp(four, axis=0)) ** 3)


def _tables(row: dict[str, Any]) -> Iterator[str]:
    name = row["type"]
    parts = [
        {
            "part": part["part"],
            "proper part of": ", ".join(above or name for above in part["proper_part_of"]),
            "discrete from": ", ".join(part["discrete_from"]) or "–",
            "features": part["features"],
        }
        for part in row["parts"]
    ]
    polygons = [{**face, "normal": _place(face["normal"])} for face in row["faces"]]
    pencils = [
        {
            "feature": pencil["feature"],
            "lobes": pencil["lobes"],
            "widest": f"{np.degrees(pencil['widest']):.0f}°",
            "range": f"{pencil['range'][0]:.4g} to {pencil['range'][1]:.4g} m",
            f"seen from, of {CELLS}": f"{pencil['seen']:.0%}",
        }
        for pencil in sorted(row["pencils"], key=lambda pencil: (-pencil["seen"], pencil["feature"]))
    ]
    sets = [
        {"set of four": ", ".join(some["features"]), "Σdv": some["dv"], "from": _place(some["viewpoint"])}
        for some in row["convergence"]
    ]
    yield from _table(f"{name}: mereology (A3)", parts)
    yield from _table(f"{name}: faces, maximal convex planar polygons (m²)", polygons)
    yield from _table(f"{name}: vector pencils", pencils)
    yield from _table(f"{name}: convergence, what one viewpoint sees", sets)


def _table(title: str, rows: list[dict[str, Any]]) -> Iterator[str]:
    """A table of the first rows; a line where there is none, or more."""
    if not rows:
        yield f"{title}: none\n"
        return
    yield plain_table(title, rows[:SHOWN])
    if len(rows) > SHOWN:
        yield f" and {len(rows) - SHOWN} more (--json has all)\n"


def _place(values: list[float]) -> str:
    return "[" + ", ".join(f"{value + 0.0:.2f}" for value in values) + "]"
