"""The volume that two posed solids share (A4, §3.1), exactly, by manifold3d. Touching bodies share none.

How far two solids reach into each other, and which way they come apart (A4, §3.1).

* ``reach(a, T_a, b, T_b)``: None where they share no volume; ``reaches``, one a connected piece of what they share

It is quick, and right where the bodies are flat where they meet; ``geometry.bodies.depth`` is exact and slower.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.errors import GeometryError
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import checked_mesh

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
        """Corners (N, 3) m, in this one's frame, of each connected piece of the volume shared with `other`, posed by `own_from_other` (4, 4)."""
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
    """The least width of each connected piece of the volume that `a` and `b` share, posed by `T_a` and `T_b` (4, 4) into one common frame.

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
