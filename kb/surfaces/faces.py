"""Faces of a surface (§2.8): maximal convex planar polygons of n ≥ 3 corners, from its coplanar facets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.connected import roots

if TYPE_CHECKING:
    from collections.abc import Iterable

    import networkx as nx
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
    normals, links = normals_of(surface), _flat_neighbours(surface)
    alone = _triangle_loops(surface, normals)
    loops = {
        region: alone[region[0]] if len(region) == 1 else _convex_loop(surface, region, normals[region[0]])
        for region in _regions(len(surface.triangles), links)
    }
    groups = [(frozenset(region), loop) for region, loop in loops.items() if loop]
    if concave := [region for region, loop in loops.items() if not loop]:
        graph = _graph(len(surface.triangles), links)
        groups += [piece for region in concave for piece in _cut(surface, region, graph, normals[region[0]])]
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


def _flat_neighbours(surface: Surface) -> list[tuple[int, int]]:
    """The pairs of facets that share an edge and a plane."""
    normals = normals_of(surface)
    pairs = [(facets[0], facets[1]) for facets in edge_facets(surface).values() if len(facets) == 2]
    return [(a, b) for a, b in pairs if np.linalg.norm(normals[a] - normals[b]) < COPLANAR]


def _regions(count: int, links: Iterable[tuple[int, int]]) -> list[tuple[int, ...]]:
    """The facets that hang together by links, each region in ascending order."""
    regions: dict[int, list[int]] = {}
    for facet, root in enumerate(roots(count, links)):
        regions.setdefault(root, []).append(facet)
    return [tuple(region) for region in regions.values()]


def _graph(count: int, links: Iterable[tuple[int, int]]) -> nx.Graph:
    """The facets and their links; few surfaces need it, and networkx is long to import."""
    import networkx as nx

    graph = nx.Graph()
    graph.add_nodes_from(range(count))
    graph.add_edges_from(links)
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


def _triangle_loops(surface: Surface, normals: NDArray[np.float64]) -> list[tuple[int, ...]]:
    """As ``_convex_loop``, of each facet alone: most faces of a scanned mesh are one."""
    first = surface.triangles.argmin(axis=1)[:, None]
    loops = np.take_along_axis(surface.triangles, (first + np.arange(3)) % 3, axis=1)
    steps = surface.vertices[np.roll(loops, -1, axis=1)] - surface.vertices[loops]
    steps /= np.linalg.norm(steps, axis=2, keepdims=True)
    turns = np.einsum("tkd,td->tk", np.cross(np.roll(steps, 1, axis=1), steps), normals)
    return [
        tuple(vertex for vertex, turn in zip(loop, some, strict=True) if turn > COPLANAR)
        for loop, some in zip(loops.tolist(), turns.tolist(), strict=True)
    ]


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
