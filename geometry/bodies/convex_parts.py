"""A solid cut into convex parts: along the planes of the facets that meet at its reflex edges (Chazelle's notches).

* ``ConvexParts(parts=((8, 3) m, (8, 3) m), exact=True)``: an L has two; ``exact`` is False where cutting was given up,
  and the one part is the hull.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints

MOST_PARTS = 40
"""Parts beyond which cutting is given up: a scan has as many dents as facets."""
MOST_REFLEX = 400
"""Reflex edges beyond which it is not begun."""
CONVEX = 1e-7
"""Share of its hull's volume by which a part may fall short of it and be convex: what cutting leaves in rounding."""
_SLIVER = 1e-12  # of the whole's volume: parts below it are rounding
_REFLEX = 1e-6  # of the part's size: the height of a neighbour's corner over a facet's plane, from which on their edge is reflex


class ConvexParts(NamedTuple):
    """``parts``: the corners (V, 3) m of each; together they fill the solid where ``exact``, and contain it otherwise."""

    parts: tuple[Floats, ...]
    exact: bool


def convex_parts(body: Any) -> ConvexParts:  # noqa: ANN401 - manifold3d ships no types
    """Of a body of manifold3d. Its hull alone, and not exact, where it would take more than ``MOST_PARTS``."""
    least = _SLIVER * body.volume()
    todo, done = list(body.decompose()), []
    while todo:
        part = todo.pop()
        hull = part.hull()
        if part.volume() <= least:
            continue
        if hull.volume() - part.volume() <= CONVEX * hull.volume():
            done.append(_corners(hull))
            continue
        halves = _halves(part, least) if len(todo) + len(done) + 2 <= MOST_PARTS else []
        if not halves:
            return ConvexParts((_corners(body.hull()),), exact=False)
        todo += halves
    return ConvexParts(tuple(done), exact=True)


def _halves(part: Any, least: float) -> list[Any]:  # noqa: ANN401 - as above
    """What the first of its notches that cuts anything off leaves, two pieces or more of over ``least`` m³; [] where none does, or for too many."""
    for plane in _notches(part):
        halves = [some for half in part.split_by_plane(*plane) for some in half.decompose() if some.volume() > least]
        if len(halves) > 1:
            return halves
    return []


def _corners(body: Any) -> Floats:  # noqa: ANN401 - as above
    return np.unique(np.asarray(body.to_mesh64().vert_properties)[:, :3], axis=0)


def _notches(part: Any) -> Iterator[tuple[list[float], float]]:  # noqa: ANN401 - as above
    """Planes (unit normal, offset) of the facets beside reflex edges, those first over which a neighbour rises highest; none for too many.

    In single precision a plane may run beside the part that it was cut along before: then it cuts nothing off, and
    another is tried.
    """
    vertices, triangles = _mesh(part)
    one, opposite = _across(triangles)
    corner = vertices[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0.0, length, 1.0)[:, None]
    rise = np.einsum("ei,ei->e", normal[one], vertices[opposite] - corner[one, 0])
    reflex = rise > _REFLEX * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if reflex.sum() > 2 * MOST_REFLEX:
        return
    edges = np.argsort(-np.where(reflex, rise, -np.inf), kind="stable")[: int(reflex.sum())]
    for facet in dict.fromkeys(one[edges].tolist()):
        yield normal[facet].tolist(), float(normal[facet] @ corner[facet, 0])


def _mesh(part: Any) -> tuple[Floats, Ints]:  # noqa: ANN401 - as above
    """Vertices (V, 3) m, each place once, and triangles (T, 3)."""
    mesh = part.to_mesh64()
    places, same = np.unique(np.asarray(mesh.vert_properties)[:, :3], axis=0, return_inverse=True)
    return places, same.ravel()[np.asarray(mesh.tri_verts).astype(np.int64)]


def _across(triangles: Ints) -> tuple[Ints, Ints]:
    """Of each edge and each way along it: the facet (E,), and that vertex of the facet beyond it which is not on the edge."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    third = np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])
    facet = np.tile(np.arange(len(triangles)), 3)
    span = int(triangles.max()) + 1
    codes, back = directed[:, 0] * span + directed[:, 1], directed[:, 1] * span + directed[:, 0]
    order = np.argsort(codes, kind="stable")
    place = np.minimum(np.searchsorted(codes[order], back), len(codes) - 1)
    met = codes[order][place] == back
    return facet[met], third[order][place][met]
