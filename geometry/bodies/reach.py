"""How far two solids reach into each other, and which way they come apart (A4, §3.1).

* ``reach(a, T_a, b, T_b)``: None where they share no volume; ``reaches``, one a connected piece of what they share

It is quick, and right where the bodies are flat where they meet; ``geometry.bodies.depth`` is exact and slower.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.bodies.overlap import Solid
from geometry.frames import inverse, transform_points


class Reach(NamedTuple):
    """``depth`` m; ``way`` (3,) unit: moved along it by so much, the second comes out of the first, if both are convex there; ``at`` (3,) m where."""

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
    """The least extent of points (N, 3) m along the normals of the facets of their hull, and that normal (3,); None of points in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        normals = ConvexHull(points).equations[:, :3]
    except (QhullError, ValueError):
        return None
    wide = np.ptp(points @ normals.T, axis=0)
    narrowest = int(wide.argmin())
    return float(wide[narrowest]), normals[narrowest]
