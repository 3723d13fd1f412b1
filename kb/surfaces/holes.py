"""Small holes of a surface, filled with a fan of triangles each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kb.surfaces.limits import LARGEST_HOLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Places = NDArray[np.float64]
    Facets = NDArray[np.int64]


def filled(vertices: Places, triangles: Facets) -> tuple[Places, Facets, int, int]:
    """Vertices, triangles, and how many holes were filled and how many left: those larger than ``LARGEST_HOLE`` of the whole.

    A hole is a loop of edges with a facet on one side only. One of three edges gets a triangle, any other a fan about
    its middle.
    """
    loops = rims(triangles)
    most = LARGEST_HOLE * np.linalg.norm(np.ptp(vertices, axis=0))
    small = [loop for loop in loops if np.linalg.norm(np.ptp(vertices[loop], axis=0)) <= most]
    middles: list[Places] = []
    facets: list[Facets] = []
    for loop in small:
        if len(loop) == 3:
            facets.append(loop[None, ::-1])
            continue
        middle = np.full(len(loop), len(vertices) + len(middles))
        middles.append(vertices[loop].mean(axis=0))
        facets.append(np.stack([np.roll(loop, -1), loop, middle], axis=1))
    if small:
        vertices, triangles = (
            np.concatenate([vertices, *[m[None] for m in middles]]),
            np.concatenate([triangles, *facets]),
        )
    return vertices, triangles, len(small), len(loops) - len(small)


def rims(triangles: Facets) -> list[NDArray[np.int64]]:
    """The loops of directed edges that no other facet runs along the other way, each vertex once in its loop.

    Edges that meet others at a vertex, so that nobody knows how to go on, are in no loop.
    """
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    span = int(directed.max(initial=0)) + 1
    codes, back = directed[:, 0] * span + directed[:, 1], directed[:, 1] * span + directed[:, 0]
    lone = directed[~np.isin(codes, back)]
    starts, counts = np.unique(lone[:, 0], return_counts=True)
    plain = set(starts[counts == 1].tolist())
    following = {a: b for a, b in lone.tolist() if a in plain}
    return _loops(following)


def _loops(following: dict[int, int]) -> list[NDArray[np.int64]]:
    """The closed walks of a function on vertices."""
    seen: set[int] = set()
    found = []
    for start in following:
        walk: list[int] = []
        place: int | None = start
        while place is not None and place not in seen:
            seen.add(place)
            walk.append(place)
            place = following.get(place)
        if place is not None and place in walk:
            loop = walk[walk.index(place) :]
            found += [np.array(loop, dtype=np.int64)] if len(loop) >= 3 else []
    return found
