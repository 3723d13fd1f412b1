"""A solid cut into convex parts: along the planes of the facets that meet at its reflex edges (Chazelle's notches).

* ``ConvexParts(parts=((8, 3) m, (8, 3) m), exact=True)``: an L has two; ``exact`` is False where cutting was given up, and the one part is the hull.
"""

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
        cut = _notch(part)
        if cut is None or len(todo) + len(done) + 2 > MOST_PARTS:
            return ConvexParts((_corners(body.hull()),), exact=False)
        todo += [some for half in part.split_by_plane(*cut) for some in half.decompose()]
    return ConvexParts(tuple(done), exact=True)


def _corners(body: Any) -> Floats:  # noqa: ANN401 - as above
    return np.unique(np.asarray(body.to_mesh64().vert_properties)[:, :3], axis=0)


def _notch(part: Any) -> tuple[list[float], float] | None:  # noqa: ANN401 - as above
    """The plane (unit normal, offset) of the facet beside the reflex edge whose neighbour rises highest over it; None for none, or too many."""
    vertices, triangles = _mesh(part)
    one, opposite = _across(triangles)
    corner = vertices[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0.0, length, 1.0)[:, None]
    rise = np.einsum("ei,ei->e", normal[one], vertices[opposite] - corner[one, 0])
    reflex = rise > _REFLEX * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if not reflex.any() or reflex.sum() > 2 * MOST_REFLEX:
        return None
    facet = one[np.where(reflex, rise, -np.inf).argmax()]
    return normal[facet].tolist(), float(normal[facet] @ corner[facet, 0])


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
