"""Penetration depth of two solids (A4, §3.1): the shortest move after which they share no volume. It does not turn.

Of convex bodies it is the distance of the origin to the boundary of their Minkowski difference, exactly. Of concave
ones, cut into convex parts, it is the shortest move out of all differences of two parts: found by trying, at the
shortest move so far, the facets of a difference that still holds it, best first. What is too dented to be cut is known
within bounds.

* ``Depth(low=0.03, high=0.03, way=array([1.0, 0.0, 0.0]))``: the second, moved by 3 cm along x, is free of the first

A ball that fits into a body: its radius bounds the body's thickness from below, however dented it is.

A solid cut into convex parts: along the planes of the facets that meet at its reflex edges (Chazelle's notches).

* ``ConvexParts(parts=((8, 3) m, (8, 3) m), exact=True)``: an L has two; ``exact`` is False where cutting was given up,
  and the one part is the hull.
"""

import heapq
from collections.abc import Iterator
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Ints, last_axes
from geometry.bodies.overlap import Solid, balls_of, near_places
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import RayMesh

MOST_PARTS = 40
"""Parts beyond which cutting is given up: a scan has as many dents as facets."""
MOST_REFLEX = 400
"""Reflex edges beyond which it is not begun."""
CONVEX = 1e-7
"""Share of its hull's volume by which a part may fall short of it and be convex: what cutting leaves in rounding."""
_SLIVER = 1e-12  # of the whole's volume: parts below it are rounding
_REFLEX = 1e-6  # of the part's size: the height of a neighbour's corner over a facet's plane, from which on their edge is reflex


class ConvexParts(NamedTuple):
    """``parts``: the corners (V, 3) m of each.

    Together they fill the solid where ``exact``, and contain it otherwise.
    """

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
    """What the first of its notches that cuts anything off leaves, two pieces or more of over ``least`` m³.

    [] where none does, or for too many.
    """
    for plane in _notches(part):
        halves = [some for half in part.split_by_plane(*plane) for some in half.decompose() if some.volume() > least]
        if len(halves) > 1:
            return halves
    return []


def _corners(body: Any) -> Floats:  # noqa: ANN401 - as above
    return np.unique(np.asarray(body.to_mesh64().vert_properties)[:, :3], axis=0)


def _notches(part: Any) -> Iterator[tuple[list[float], float]]:  # noqa: ANN401 - as above
    """Planes (unit normal, offset) of the facets beside reflex edges; none where there are too many.

    Those come first over which a neighbour rises highest.

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
    """Of each edge and each way along it.

    The facet (E,), and that vertex of the facet beyond it which is not on the edge.
    """
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    third = np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])
    facet = np.tile(np.arange(len(triangles)), 3)
    span = int(triangles.max()) + 1
    codes, back = directed[:, 0] * span + directed[:, 1], directed[:, 1] * span + directed[:, 0]
    order = np.argsort(codes, kind="stable")
    place = np.minimum(np.searchsorted(codes[order], back), len(codes) - 1)
    met = codes[order][place] == back
    return facet[met], third[order][place][met]


TRIED = 200
"""Facets from whose middles a chord is drawn into the body; its own middle is where a ball is tried."""


MOST_TRIED = 300
"""Moves that are tried for concave bodies; then the shortest still open is the lower bound."""
MOST_CORNERS = 60_000
"""Corners of a Minkowski difference that is built as a whole; of more, only those near the way out are asked for."""
EXACT = 1e-9
"""Metres between two bounds that count as one number."""
_IMPOSSIBLE = 1e-10  # residual of the least-distance problem below which its rows contradict each other


class Depth(NamedTuple):
    """``low`` to ``high`` m contain the depth.

    Moved by ``high`` along ``way`` (3,), unit, common frame, the second is free of the first.
    """

    low: float
    high: float
    way: Floats

    @property
    def value(self) -> float:
        """The depth in one number, m: what is sure to suffice, ``high``."""
        return self.high


class _Difference(NamedTuple):
    """Moves p of the second that leave it in the first: normals (F, 3) · p < reach (F,) m.

    They are the convex polytope of ``corners`` (V, 3) m.
    """

    normals: Floats
    reach: Floats
    corners: Floats


class _Tried(NamedTuple):
    """The shortest ``move`` (3,) m that is ``outside`` of so many facets, a unit normal and reach each.

    Ordered by its length, then ``number``.
    """

    length: float
    number: int
    outside: Floats
    move: Floats


def penetration(a: Solid, T_a: ArrayLike, b: Solid, T_b: ArrayLike) -> Depth | None:
    """Of the solids `a` and `b`, posed by `T_a` and `T_b` (4, 4) into one common frame.

    None where they share no volume.
    """
    own_from_other = inverse(T_a) @ last_axes(T_b, (4, 4), "T_b")
    if not a.shared(own_from_other, b) > 0.0:
        return None
    first, second = parts_of(a), parts_of(b)
    pairs = [(p, transform_points(own_from_other, q)) for p in first.parts for q in second.parts]
    differences = [one for p, q in pairs if (one := _difference(p, q, whole=len(pairs) > 1)) is not None]
    low, move = _way_out(differences)
    high = float(np.linalg.norm(move))
    if not (first.exact and second.exact):
        low = min(high, 2.0 * inscribed_radius(a.meet(own_from_other, b)))
    low = high if high - low < EXACT else low
    return Depth(low, high, last_axes(T_a, (4, 4), "T_a")[:3, :3] @ move / max(high, 1e-300))


@lru_cache(maxsize=256)
def parts_of(solid: Solid) -> ConvexParts:
    """The convex parts of a solid, cut once."""
    return convex_parts(solid.body)


def _difference(p: Floats, q: Floats, *, whole: bool) -> _Difference | None:
    """The moves of the convex body of corners q (N, 3) that leave it in that of p (M, 3).

    None where rounding leaves them no volume.
    """
    from scipy.spatial import ConvexHull, QhullError

    few = whole or len(p) * len(q) <= MOST_CORNERS
    try:
        points = (p[:, None] - q[None]).reshape(-1, 3) if few else _near_the_origin(p, q)
        hull = ConvexHull(points)
    except QhullError:
        return None
    facets = hull.equations[np.unique(hull.equations.round(9), axis=0, return_index=True)[1]]
    return _Difference(facets[:, :3], -facets[:, 3], points[hull.vertices])


def _near_the_origin(p: Floats, q: Floats) -> Floats:
    """Corners (N, 3) of the difference, enough to tell where its boundary is nearest.

    A polytope grows there until it reaches the boundary (EPA).
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(_supports(p, q, np.concatenate([np.eye(3), -np.eye(3)])), incremental=True)
    while True:
        reach = -hull.equations[:, 3]
        nearest = hull.equations[reach <= reach.min() + EXACT, :3]
        more = _supports(p, q, nearest)
        if ((more * nearest).sum(axis=1) - reach.min() <= 2.0 * EXACT).all():
            return np.asarray(hull.points)
        hull.add_points(more)


def _supports(p: Floats, q: Floats, ways: Floats) -> Floats:
    """The corners (N, 3) of the difference that are farthest along `ways` (N, 3)."""
    return np.asarray(p[(p @ ways.T).argmax(axis=0)] - q[(q @ ways.T).argmin(axis=0)])


def _way_out(differences: list[_Difference]) -> tuple[float, Floats]:
    """A lower bound, m, of the shortest move out of all these polytopes, and the shortest (3,) that was found."""
    best, number = _straight_out(differences), count()
    queue = [_Tried(0.0, next(number), np.zeros((0, 4)), np.zeros(3))]
    for _ in range(MOST_TRIED):
        most = float(np.linalg.norm(best))
        if not queue or queue[0].length >= most - EXACT:
            return most, best
        tried = heapq.heappop(queue)
        inside = _holding(tried.move, differences)
        if inside is None:
            return tried.length, tried.move
        for facet in np.column_stack([inside.normals, inside.reach])[inside.reach < most]:
            outside = np.vstack([tried.outside, facet])
            move = _shortest(outside)
            if move is not None and (length := float(np.linalg.norm(move))) < most:
                heapq.heappush(queue, _Tried(length, next(number), outside, move))
    return (queue[0].length if queue else float(np.linalg.norm(best))), best


def _straight_out(differences: list[_Difference]) -> Floats:
    """The shortest move (3,) along one facet's normal that leaves all the polytopes behind it.

    It is an upper bound, and the depth itself for one polytope.
    """
    ways = np.concatenate([one.normals for one in differences])
    reach = np.max([(one.corners @ ways.T).max(axis=0) for one in differences], axis=0)
    shortest = int(reach.argmin())
    return np.asarray(ways[shortest] * reach[shortest])


def _holding(move: Floats, differences: list[_Difference]) -> _Difference | None:
    """That of the polytopes which holds a move (3,) deepest inside; None where none does."""
    deep = [float((one.reach - one.normals @ move).min()) for one in differences]
    deepest = int(np.argmax(deep))
    return differences[deepest] if deep[deepest] > EXACT else None


def _shortest(outside: Floats) -> Floats | None:
    """The shortest move (3,) with normal · move >= reach for rows (K, 4) of normal and reach: Lawson and Hanson's LDP.

    None where there is none.
    """
    from scipy.optimize import nnls

    size = float(np.abs(outside[:, 3]).max())
    force, _ = nnls(np.vstack([outside[:, :3].T, outside[:, 3] / size]), np.array([0.0, 0.0, 0.0, 1.0]))
    left = np.concatenate([outside[:, :3].T @ force, [outside[:, 3] @ force / size - 1.0]])
    return None if abs(left[3]) < _IMPOSSIBLE else np.asarray(-left[:3] / left[3] * size)


def inscribed_radius(body: Any) -> float:  # noqa: ANN401 - manifold3d ships no types
    """Radius, m, of the largest of some balls inside a body of manifold3d.

    Each is about the middle of a chord at right angles to a large facet.
    """
    mesh = body.to_mesh64()
    vertices, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    large = np.argsort(-area, kind="stable")[:TRIED]
    large = large[area[large] > 0.0]
    if not len(large):
        return 0.0
    inward = -normals[large] / area[large, None]
    starts = corners[large].mean(axis=1)
    rays = RayMesh(vertices, triangles)
    chords = rays.first_hit(
        starts + 1e-6 * rays.size * inward, inward
    )  # a little inside, so that the facet itself is not met
    kept = np.isfinite(chords)
    middles, best = starts[kept] + 0.5 * chords[kept, None] * inward[kept], 0.0
    balls = balls_of(corners)
    for place in np.argsort(-chords[kept], kind="stable"):
        if 0.5 * chords[kept][place] > best:
            near = near_places(vertices, triangles, balls, middles[place])
            best = max(best, float(np.linalg.norm(near - middles[place], axis=1).min()))
    return best
