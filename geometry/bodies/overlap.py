"""How two posed bodies lie to each other: the volume that they share, how far they reach into each other, their gap.

The shared volume (A4, §3.1) is exact, by manifold3d. Touching bodies share none.

How far two solids reach into each other, and which way they come apart (A4, §3.1).

* ``reach(a, T_a, b, T_b)``: None where they share no volume; ``reaches``, one a connected piece of what they share

It is quick, and right where the bodies are flat where they meet; ``geometry.bodies.depth`` is exact and slower.

The gap between two bodies, and a body's distance from the camera or another place: metres between surfaces, 0 where
bodies meet.

* ``Spread``: points spread over a surface, and balls round its facets, which tell the nearest place fast
"""

from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Ints, last_axes
from geometry.errors import GeometryError
from geometry.frames import inverse, transform_points
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.rays import RayMesh, checked_mesh

_ROUNDING = 1e-10  # of the smaller volume: below this a shared volume is rounding, and counts as none


class Solid:
    """A closed surface as a solid, made once a type and then posed at will: `vertices` (V, 3) m, `triangles` (T, 3).

    Raises:
        GeometryError: where the surface is not a closed, manifold one, or is inside out.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        """Check the surface, and hand it to manifold3d."""
        self.vertices, self.triangles = checked_mesh(vertices, triangles)
        self.centre = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        self.radius = float(np.linalg.norm(self.vertices - self.centre, axis=1).max())
        self.body = _manifold(self.vertices, self.triangles)
        if not self.volume > 0:
            raise GeometryError(f"the surface must enclose a volume, facets outward, not {self.volume:g} m^3")

    @cached_property
    def volume(self) -> float:
        """Enclosed volume, m^3."""
        return float(self.body.volume())

    def shared(self, own_from_other: ArrayLike, other: "Solid") -> float:
        """Volume in m^3 shared with `other`, posed by `own_from_other` (4, 4); exactly 0 for touching."""
        T = last_axes(own_from_other, (4, 4), "own_from_other")
        if self._apart(T, other):
            return 0.0
        volume = float(self.meet(T, other).volume())
        return volume if volume > _ROUNDING * min(self.volume, other.volume) else 0.0

    def pieces(self, own_from_other: ArrayLike, other: "Solid") -> list[Floats]:
        """Corners (N, 3) m, in this one's frame, of each connected piece of the volume shared with `other`.

        `other` is posed by `own_from_other` (4, 4).
        """
        T = last_axes(own_from_other, (4, 4), "own_from_other")
        if not self.shared(T, other) > 0.0:
            return []
        return [np.asarray(piece.to_mesh64().vert_properties)[:, :3] for piece in self.meet(T, other).decompose()]

    def meet(self, own_from_other: ArrayLike, other: "Solid") -> Any:  # noqa: ANN401 - manifold3d ships no types
        """What is common to both, in this one's frame, as manifold3d has it.

        `other` posed by `own_from_other` (4, 4).
        """
        return self.body ^ other.body.transform(last_axes(own_from_other, (4, 4), "own_from_other")[:3])

    def _apart(self, T: Floats, other: "Solid") -> bool:
        """The cheap answer: the spheres round the two, or the boxes along this one's axes, do not meet."""
        place = T[:3, :3] @ other.centre + T[:3, 3]
        if np.linalg.norm(place - self.centre) >= self.radius + other.radius:
            return True
        moved = transform_points(T, other.vertices)
        gap = np.maximum(self.vertices.min(axis=0) - moved.max(axis=0), moved.min(axis=0) - self.vertices.max(axis=0))
        return bool((gap >= 0).any())


def solid_overlap(a: Solid, T_a: ArrayLike, b: Solid, T_b: ArrayLike) -> float:
    """Volume in m^3 that the solids `a` and `b` share, posed by `T_a` and `T_b` (4, 4) into one common frame."""
    return a.shared(inverse(T_a) @ last_axes(T_b, (4, 4), "T_b"), b)


def _manifold(vertices: Floats, triangles: ArrayLike) -> Any:  # noqa: ANN401 - manifold3d ships no types
    from manifold3d import Error, Manifold, Mesh64

    body = Manifold(Mesh64(np.array(vertices), np.array(triangles, dtype=np.uint64)))
    if body.status() != Error.NoError:
        raise GeometryError(f"the surface must be closed and manifold for its volume: {body.status().name}")
    return body


class Reach(NamedTuple):
    """``depth`` m.

    ``way`` (3,) unit: moved along it by so much, the second comes out of the first, if both are convex there; ``at``
    (3,) m where.
    """

    depth: float
    way: Floats
    at: Floats


def reach(a: Solid, T_a: ArrayLike, b: Solid, T_b: ArrayLike) -> Reach | None:
    """The deepest of their `reaches`; None where they share no volume."""
    return max(reaches(a, T_a, b, T_b), key=lambda one: one.depth, default=None)


def reaches(a: Solid, T_a: ArrayLike, b: Solid, T_b: ArrayLike) -> list[Reach]:
    """The least width of each connected piece of the volume that `a` and `b` share.

    Both are posed by `T_a` and `T_b` (4, 4) into one common frame.
    Two that interlock share pieces far from each other, of which the hull would span what neither fills.
    """
    own_from_other = inverse(T_a) @ last_axes(T_b, (4, 4), "T_b")
    apart = transform_points(T_b, b.centre[None])[0] - transform_points(T_a, a.centre[None])[0]
    found = []
    for piece in a.pieces(own_from_other, b):
        corners = transform_points(T_a, piece)
        width = least_width(corners)
        if width is not None:
            depth, way = width
            found.append(
                Reach(depth, way if way @ apart >= 0.0 else -way, 0.5 * (corners.min(axis=0) + corners.max(axis=0)))
            )
    return found


def least_width(points: Floats) -> tuple[float, Floats] | None:
    """The least extent of points (N, 3) m along the normals of the facets of their hull, and that normal (3,).

    None of points in a plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        normals = ConvexHull(points).equations[:, :3]
    except (QhullError, ValueError):
        return None
    wide = np.ptp(points @ normals.T, axis=0)
    narrowest = int(wide.argmin())
    return float(wide[narrowest]), normals[narrowest]


FEW = 20_000
"""Pairs of facets that are gone through one by one; of more, the nearest are found from points spread over both
surfaces."""
SPREAD = 500
"""Such points, and about as many corners at most."""
STEPS = 20
"""Times, at most, that the nearest place on the one is followed to the nearest on the other."""
SETTLED = 1e-3
"""Share of the gap by which a step must lessen it, or the next is not taken."""


class Balls(NamedTuple):
    """Balls that hold facets: their ``middles`` (T, 3) and ``radii`` (T,)."""

    middles: Floats
    radii: Floats


class Spread(NamedTuple):
    """``points`` (N, 3) m, object frame, and their k-d tree."""

    points: Floats
    tree: Any


def gap(x: PosedSurface, y: PosedSurface, solids: tuple[Solid | None, Solid | None] = (None, None)) -> float:
    """Metres between two posed surfaces, the least; 0 where their `solids`, if both are known, share volume or touch.

    Exact for two solids of few facets; else it may be larger, by no more than is between the points that are spread
    over a surface.
    """
    first, second = solids
    own_from_other = x.object_from_camera @ y.camera_from_object
    if first is not None and second is not None:
        if len(first.triangles) * len(second.triangles) <= FEW:
            between = float(np.linalg.norm(transform_points(own_from_other, second.centre[None])[0] - first.centre))
            return float(
                first.body.min_gap(second.body.transform(own_from_other[:3]), between + first.radius + second.radius)
            )
        if first.shared(own_from_other, second) > 0.0:
            return 0.0
    return _followed(x, y, own_from_other)


def distance(surface: PosedSurface, place_camera: Floats | None = None) -> float:
    """Metres from a place (3,), camera frame, or the camera's centre, to the nearest place of a posed surface."""
    place = np.zeros(3) if place_camera is None else place_camera
    eye = transform_points(surface.object_from_camera, place[None])[0]
    return float(np.linalg.norm(_nearest(surface, eye) - eye))


def _followed(x: PosedSurface, y: PosedSurface, x_from_y: Floats) -> float:
    """From the nearest two of the spread points on, by the nearest place on either surface in turn."""
    first, second = spread(x.rays), spread(y.rays)
    far, at = first.tree.query(transform_points(x_from_y, second.points))
    best, here = float(far.min()), first.points[at[far.argmin()]]
    y_from_x = y.object_from_camera @ x.camera_from_object
    for _ in range(STEPS):
        beyond = transform_points(x_from_y, _nearest(y, transform_points(y_from_x, here[None])[0])[None])[0]
        here = _nearest(x, beyond)
        before, best = best, min(best, float(np.linalg.norm(here - beyond)))
        if before - best <= SETTLED * best + SETTLED**2:
            break
    return best


def _nearest(surface: PosedSurface, place: Floats) -> Floats:
    """The place (3,) of a surface that is nearest to another, object frame."""
    near = near_places(surface.vertices, surface.triangles, _balls(surface.rays), place)
    return np.asarray(near[np.linalg.norm(near - place, axis=1).argmin()])


def near_places(vertices: Floats, triangles: Ints, balls: Balls, place: Floats) -> Floats:
    """Places (K, 3) on those of the triangles (T, 3) that may be nearest to `place` (3,), as their `balls` tell."""
    far = np.linalg.norm(balls.middles - place, axis=1)
    return nearest_places(vertices[triangles[far - balls.radii <= (far + balls.radii).min()]], place)


def balls_of(corners: Floats) -> Balls:
    """Of triangles (T, 3, 3)."""
    middles = corners.mean(axis=1)
    return Balls(middles, np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1))


@lru_cache(maxsize=256)
def _balls(rays: RayMesh) -> Balls:
    """Of the facets of one surface, once."""
    return balls_of(rays.vertices[rays.triangles])


@lru_cache(maxsize=256)
def spread(rays: RayMesh) -> Spread:
    """Of one surface, once; always the same points."""
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(0)
    corners = rays.vertices[rays.triangles]
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    some = rng.choice(len(area), SPREAD, p=area / area.sum()) if area.sum() > 0.0 else np.zeros(SPREAD, dtype=np.intp)
    u, v = np.sort(rng.random((2, SPREAD)), axis=0)[..., None]
    points = np.concatenate(
        [rays.vertices[:: 1 + len(rays.vertices) // SPREAD], u * a[some] + (v - u) * b[some] + (1.0 - v) * c[some]]
    )
    return Spread(points, cKDTree(points))


def nearest_places(corners: Floats, place: Floats) -> Floats:
    """The places (T, 3), one on each triangle of `corners` (T, 3, 3), that are nearest to `place` (3,)."""
    sides = np.roll(corners, -1, axis=1) - corners
    length = (sides**2).sum(axis=2)
    share = np.clip(((place - corners) * sides).sum(axis=2) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    on_edges = corners + share[..., None] * sides
    best = ((on_edges - place) ** 2).sum(axis=2).argmin(axis=1)
    found = np.take_along_axis(on_edges, best[:, None, None], axis=1)[:, 0]
    normal = np.cross(sides[:, 0], sides[:, 1])
    area = (normal**2).sum(axis=1)
    foot = place - (((place - corners[:, 0]) * normal).sum(axis=1) / np.where(area > 0.0, area, 1.0))[:, None] * normal
    turns = (np.cross(sides, foot[:, None] - corners) * normal[:, None]).sum(axis=2)
    return np.where(((turns >= 0.0).all(axis=1) & (area > 0.0))[:, None], foot, found)
