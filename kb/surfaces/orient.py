"""Facets all turned the same way, outward: along each edge the two facets run opposite ways, and what is enclosed is positive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Places = NDArray[np.float64]
    Facets = NDArray[np.int64]


def turned_outward(vertices: Places, triangles: Facets) -> Facets:
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


def _volumes(vertices: Places, triangles: Facets) -> Places:
    """The signed volume (T,) between each triangle and the middle of all."""
    a, b, c = np.moveaxis(vertices[triangles] - vertices.mean(axis=0), 1, 0)
    return np.asarray(np.einsum("ti,ti->t", a, np.cross(b, c)) / 6)


def _neighbours(triangles: Facets) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """The facets on both sides of each edge that has just two, and whether they run along it the same way, which is wrong."""
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


def _agreeing(count: int, one: NDArray[np.intp], other: NDArray[np.intp], same: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which facets (T,) to turn over, so that neighbours along a spanning tree agree; a root added to every piece starts it."""
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
