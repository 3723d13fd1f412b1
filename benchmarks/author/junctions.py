"""How a vertex of a surface looks: the junction that its edges make in the image, and from where.

Vocabulary: ``Region``, the directions from which the same facets are seen, making the same junction, and the least cone
round them. A cuboid's corner has 7: one Y, three arrows, three Ls. What stands in front is not asked here: rays tell.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np

from geometry.cones import even_directions, spacing

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from kb.surfaces.surface import Surface

COPLANAR = 1e-6
"""Facets whose unit normals differ by less lie in one plane, where they share an edge; radians."""


@dataclass(frozen=True, eq=False)
class Face:
    """``loop`` of vertices, counterclockwise from outside, no three in line; unit ``normal`` (3,) outward.

    ``triangles``.
    """

    loop: tuple[int, ...]
    normal: NDArray[np.float64]
    triangles: tuple[int, ...]


def faces(surface: Surface) -> tuple[Face, ...]:
    """The faces in the order of their first triangle; each triangle is in exactly one.

    A flat region that is not convex is cut: neighbours join while they stay convex, so no two of its faces could be
    one.
    """
    normals, graph = normals_of(surface), _flat_neighbours(surface)
    groups: list[tuple[frozenset[int], tuple[int, ...]]] = []
    for region in nx.connected_components(graph):
        whole = _convex_loop(surface, region, normals[min(region)])
        groups += [(frozenset(region), whole)] if whole else _cut(surface, region, graph, normals[min(region)])
    groups.sort(key=lambda group: min(group[0]))
    return tuple(Face(loop, normals[min(inside)], tuple(sorted(inside))) for inside, loop in groups)


def normals_of(surface: Surface) -> NDArray[np.float64]:
    """Unit outward normals (T, 3), read-only."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    across = np.cross(b - a, c - a)
    normals = np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))
    normals.setflags(write=False)
    return normals


def edge_facets(surface: Surface) -> dict[tuple[int, int], list[int]]:
    """The facets of each edge, an edge being its two vertices in ascending order."""
    found: dict[tuple[int, int], list[int]] = {}
    for index, (a, b, c) in enumerate(surface.triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            found.setdefault((min(edge), max(edge)), []).append(index)
    return found


def _flat_neighbours(surface: Surface) -> nx.Graph:
    """The graph of the facets, linked where they share an edge and a plane."""
    normals, graph = normals_of(surface), nx.Graph()
    graph.add_nodes_from(range(len(surface.triangles)))
    for facets in edge_facets(surface).values():
        if len(facets) == 2 and np.linalg.norm(normals[facets[0]] - normals[facets[1]]) < COPLANAR:
            graph.add_edge(*facets)
    return graph


def _cut(
    surface: Surface, region: Iterable[int], graph: nx.Graph, normal: NDArray[np.float64]
) -> list[tuple[frozenset[int], tuple[int, ...]]]:
    """Join the region's facets, neighbours first come first, until no two of the pieces make a convex polygon."""
    piece = {index: frozenset([index]) for index in sorted(region)}
    links, joined = sorted(graph.subgraph(piece).edges), True
    while joined:
        joined = False
        for a, b in links:
            union = piece[a] | piece[b]
            if piece[a] != piece[b] and _convex_loop(surface, union, normal):
                piece.update(dict.fromkeys(union, union))
                joined = True
    return [(inside, _convex_loop(surface, inside, normal)) for inside in set(piece.values())]


def _convex_loop(surface: Surface, inside: Iterable[int], normal: NDArray[np.float64]) -> tuple[int, ...]:
    """The corners round the facets ``inside``; () where their outline is not one convex polygon."""
    loop = _outline(surface.triangles[sorted(inside)].tolist())
    if not loop:
        return ()
    places = surface.vertices[list(loop)]
    steps = np.roll(places, -1, axis=0) - places
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = np.cross(np.roll(steps, 1, axis=0), steps) @ normal
    if (turns < -COPLANAR).any():
        return ()
    return tuple(vertex for vertex, turn in zip(loop, turns, strict=True) if turn > COPLANAR)


def _outline(triangles: list[list[int]]) -> tuple[int, ...]:
    """The one loop of directed edges without a counterpart; () where there are several, or they touch themselves."""
    edges = {edge for a, b, c in triangles for edge in ((a, b), (b, c), (c, a))}
    rim = {a: b for a, b in edges if (b, a) not in edges}
    if len(rim) != sum((b, a) not in edges for a, b in edges):
        return ()
    start = min(rim)
    loop = [start]
    while rim[loop[-1]] != start:
        loop.append(rim[loop[-1]])
    return tuple(loop) if len(loop) == len(rim) else ()


STRAIGHT = 1e-3
"""A gap between arms that differs from π by less is straight, rad."""
SAMPLES = 20_000
RARE = 1e-3
"""Regions with a smaller share of all directions are slivers of the sampling, and left out."""


@dataclass(frozen=True, eq=False)
class Region:
    """``kind`` of junction; the cone's unit ``axis`` (3,), object frame, and ``half_angle`` rad.

    ``share`` of directions.
    """

    kind: str
    axis: NDArray[np.float64]
    half_angle: float
    share: float


def arms(surface: Surface, vertex: int) -> NDArray[np.float64]:
    """Unit directions (K, 3), object frame, of the edges that leave ``vertex``; edges inside a flat face are none."""
    return _arms(surface, vertex)[0]


def junctions(surface: Surface, vertex: int, samples: int = SAMPLES) -> tuple[Region, ...]:
    """The regions of ``vertex``, the largest first; a vertex inside a face or on a straight edge may have none."""
    directions = even_directions(samples)
    seen = facets_seen(surface, vertex, directions)
    kinds = junction_kinds(surface, vertex, directions)
    keys = np.column_stack([seen, np.unique(kinds, return_inverse=True)[1]])
    region = np.unique(keys, axis=0, return_inverse=True)[1]
    found = []
    for label in range(region.max() + 1):
        inside = region.ravel() == label
        if kinds[inside][0] and inside.mean() >= RARE:
            axis, half_angle = enclosing_cone(directions[inside])
            found.append(Region(str(kinds[inside][0]), axis, half_angle + spacing(samples), float(inside.mean())))
    return tuple(sorted(found, key=lambda r: (-round(r.share, 3), r.kind, *np.round(r.axis, 3))))


def facets_seen(surface: Surface, vertex: int, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N, k) which of the k planes that meet at ``vertex`` face a viewpoint in the ``directions`` (N, 3) from it."""
    own = normals_of(surface)[(surface.triangles == vertex).any(axis=1)]
    planes = np.unique(np.round(own, 9), axis=0)
    return np.asarray(directions @ planes.T > 0)


def junction_kinds(surface: Surface, vertex: int, directions: NDArray[np.float64]) -> NDArray[np.str_]:
    """The kind (N,) of junction from each of the ``directions`` (N, 3); '' for fewer than two arms, or two in one line.

    An arm is seen where one of its two facets is. Two arms make an l_junction; three a t_junction with a gap of π, an
    arrow_junction with a larger one, a y_junction with none; four or more a multi_junction.
    """
    lines, sides = _arms(surface, vertex)
    seen = (np.einsum("ni,ksi->nks", directions, sides) > 0).any(axis=2)
    number, beyond = seen.sum(axis=1), widest_gap(lines, seen, directions) - np.pi
    kinds = [
        (number > 3, "multi_junction"),
        ((number == 3) & (np.abs(beyond) <= STRAIGHT), "t_junction"),
        ((number == 3) & (beyond > 0), "arrow_junction"),
        (number == 3, "y_junction"),
        ((number == 2) & (beyond > STRAIGHT), "l_junction"),
    ]
    return np.select([where for where, _ in kinds], [kind for _, kind in kinds], default="")


def widest_gap(
    lines: NDArray[np.float64], seen: NDArray[np.bool_], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The widest angle (N,) rad between neighbours of the arms ``lines`` (K, 3) that are ``seen`` (N, K), in the image.

    The image is the plane across each of the ``directions`` (N, 3); fewer than two arms leave a whole turn.
    """
    right = np.cross(directions, np.eye(3)[np.abs(directions).argmin(axis=1)])
    angles = np.arctan2(np.cross(directions, right) @ lines.T, right @ lines.T)
    turns = np.sort(np.where(seen, angles, np.nan), axis=1)  # those unseen go last
    last = np.nanmax(np.where(seen, angles, -np.inf), axis=1)
    gaps = np.column_stack([np.diff(turns, axis=1), turns[:, 0] + 2 * np.pi - last])
    return np.asarray(np.where(seen.sum(axis=1) > 1, np.nanmax(np.nan_to_num(gaps, nan=0.0), axis=1), 2 * np.pi))


def _arms(surface: Surface, vertex: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit directions (K, 3) of the arms, and the normals (K, 2, 3) of their facets."""
    normals, lines, sides = normals_of(surface), [], []
    for edge, facets in sorted(edge_facets(surface).items()):
        if vertex in edge and np.linalg.norm(normals[facets[0]] - normals[facets[1]]) > COPLANAR:
            lines.append(surface.vertices[sum(edge) - vertex] - surface.vertices[vertex])
            sides.append(normals[facets])
    directions = np.array(lines).reshape(-1, 3)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True), np.array(sides).reshape(-1, 2, 3)


GRAIN = 1e-9
"""Of cosines, below which two are one."""


def enclosing_cone(directions: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The axis (3,) and the half-angle, rad, of the least cone round unit ``directions`` (N ≥ 1, 3).

    Exact: a least cone is held by one, two or three of them; the farthest one outside joins the holders until none is.
    """
    held = [0]
    while True:
        axis, cosine = _held_by(directions[held])
        reach = directions @ axis
        farthest = int(reach.argmin())
        if reach[farthest] >= cosine - GRAIN or farthest in held:
            return axis, float(np.arccos(np.clip(min(cosine, reach[farthest]), -1, 1)))
        held.append(farthest)


def _held_by(few: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The least cone round a few directions, by trying every pair and triple: its axis and its half-angle's cosine."""
    axes = [few[0]] + [a + b for a, b in combinations(few, 2)]
    for a, b, c in combinations(few, 3):
        across = np.cross(b - a, c - a)
        axes += [across, -across]
    lengths = np.linalg.norm(axes, axis=1)
    units = np.array(axes)[lengths > GRAIN] / lengths[lengths > GRAIN, None]
    cosines = (units @ few.T).min(axis=1)
    best = int(cosines.argmax())
    return units[best], float(cosines[best])
