"""Ints all turned the same way, outward.

Along each edge the two facets run opposite ways, and what is enclosed is positive.
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints, Mask
from geometry.visibility.outline import is_closed

LARGEST_HOLE = 0.2
"""A hole is filled whose bounding box's diagonal is at most this share of the mesh's; a larger one may be meant: a
mug's mouth."""
FLAPS = 0.05
"""Share of the triangles up to which two back to back are taken for a flap, and beyond it for a sheet's two sides."""


def closed_up(vertices: Floats, triangles: Ints) -> tuple[Floats, Ints, int, int]:
    """Vertices, triangles, holes filled and holes left, of the first way of cleaning that closes the surface.

    Else of the last.
    """
    result = vertices, triangles, 0, 0
    for single in _once(triangles):
        places, facets, holes, left = filled(vertices, turned_outward(vertices, single))
        result = places, turned_outward(places, facets), holes, left
        if is_closed(result[1]):
            break
    return result


def joined_twice(triangles: Ints) -> int:
    """How many triangles another one repeats."""
    return len(triangles) - len(np.unique(np.sort(triangles, axis=1), axis=0))


def _once(triangles: Ints) -> list[Ints]:
    """Each triangle once, whichever way it faces, in one or two ways.

    Of two triangles back to back, which enclose nothing, neither may be meant: a flap, or the wall between two bodies
    that touch. Or one of them: a sheet drawn from both sides, which takes its vertices with it. The likelier way is the
    last.
    """
    _, first, group, count = np.unique(
        np.sort(triangles, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    facing = np.bincount(group.ravel(), weights=_parity(triangles))
    flap = (count == 2) & (facing == 0)
    one, neither = triangles[np.sort(first)], triangles[np.sort(first[~flap])]
    if not flap.any() or len(np.unique(neither)) < (1 - FLAPS) * len(np.unique(one)):
        return [one]
    return [neither, one] if flap.sum() > FLAPS * len(first) else [one, neither]


def _parity(triangles: Ints) -> Ints:
    """1 for triangles (T, 3) whose vertices, in order, are an even permutation of ascending ones, else -1."""
    a, b, c = triangles.T
    return np.asarray(np.sign((b - a) * (c - b) * (c - a)))


def filled(vertices: Floats, triangles: Ints) -> tuple[Floats, Ints, int, int]:
    """Vertices, triangles, and how many holes were filled and how many left.

    Those larger than ``LARGEST_HOLE`` of the whole.

    A hole is a loop of edges with a facet on one side only. One of three edges gets a triangle, any other a fan about
    its middle.
    """
    loops = rims(triangles)
    most = LARGEST_HOLE * np.linalg.norm(np.ptp(vertices, axis=0))
    small = [loop for loop in loops if np.linalg.norm(np.ptp(vertices[loop], axis=0)) <= most]
    middles: list[Floats] = []
    facets: list[Ints] = []
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


def rims(triangles: Ints) -> list[Ints]:
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


def _loops(following: dict[int, int]) -> list[Ints]:
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


def turned_outward(vertices: Floats, triangles: Ints) -> Ints:
    """The triangles (T, 3), some of them turned over.

    Where neighbours already agree everywhere, the whole is turned if its volume is negative, so that inner walls stay
    inner. Otherwise each connected piece is made to agree with itself, and turned outward by its own volume.
    """
    one, other, same = _neighbours(triangles)
    if not same.any():
        outward = _volumes(vertices, triangles).sum() >= 0
        return triangles if outward else triangles[:, ::-1].copy()
    turned = _agreeing(len(triangles), one, other, same)
    result = np.where(turned[:, None], triangles[:, ::-1], triangles)
    label = pieces(len(triangles), one, other)
    inward = np.bincount(label, weights=_volumes(vertices, result)) < 0
    return np.where(inward[label][:, None], result[:, ::-1], result)


def _volumes(vertices: Floats, triangles: Ints) -> Floats:
    """The signed volume (T,) between each triangle and the middle of all."""
    a, b, c = np.moveaxis(vertices[triangles] - vertices.mean(axis=0), 1, 0)
    return np.asarray(np.einsum("ti,ti->t", a, np.cross(b, c)) / 6)


def _neighbours(triangles: Ints) -> tuple[NDArray[np.intp], NDArray[np.intp], Mask]:
    """The facets on both sides of each edge of two facets, and whether they wrongly run along it the same way."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    facet = np.tile(np.arange(len(triangles)), 3)
    forward = directed[:, 0] < directed[:, 1]
    low, high = directed.min(axis=1), directed.max(axis=1)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    new = np.concatenate([[True], (low[1:] != low[:-1]) | (high[1:] != high[:-1])])
    start = np.flatnonzero(new)
    pairs = start[np.diff(np.append(start, len(order))) == 2]
    one, other = order[pairs], order[pairs + 1]
    return facet[one], facet[other], forward[one] == forward[other]


def pieces(count: int, one: NDArray[np.intp], other: NDArray[np.intp]) -> NDArray[np.intp]:
    """The number (T,) of each facet's connected piece."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])


def _agreeing(count: int, one: NDArray[np.intp], other: NDArray[np.intp], same: Mask) -> Mask:
    """Which facets (T,) to turn over, so that neighbours along a spanning tree agree.

    A root added to every piece starts it.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    label = pieces(count, one, other)
    first = np.unique(label, return_index=True)[1]
    rows, columns = np.concatenate([one, first]), np.concatenate([other, np.full(len(first), count)])
    weights = np.concatenate([np.where(same, 2.0, 1.0), np.ones(len(first))])
    links = coo_array((weights, (rows, columns)), shape=(count + 1, count + 1)).tocsr()
    links = links.maximum(links.T).tocsr()
    order, above = breadth_first_order(links, count, directed=False)
    flip = np.zeros(count + 1, dtype=bool)
    wrong = dict(zip(zip(one.tolist(), other.tolist(), strict=True), same.tolist(), strict=True))
    for node in order[1:].tolist():
        parent = int(above[node])
        flip[node] = flip[parent] ^ (wrong.get((node, parent), False) or wrong.get((parent, node), False))
    return flip[:count]
