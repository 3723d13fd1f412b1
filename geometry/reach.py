"""How far two solids reach into each other, and which way they come apart (A4, §3.1).

* ``reach(a, T_a, b, T_b)``: None where they share no volume
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.frames import inverse, transform_points
from geometry.overlap import Solid


class Reach(NamedTuple):
    """``depth`` m; ``way`` (3,) unit: moved along it by so much, the second comes out of the first, if both are convex there; ``at`` (3,) m where."""

    depth: float
    way: Floats
    at: Floats


def reach(a: Solid, T_a: ArrayLike, b: Solid, T_b: ArrayLike) -> Reach | None:
    """The least width of the volume that `a` and `b` share, posed by `T_a` and `T_b` (4, 4) into one common frame; None where they share none."""
    own_from_other = inverse(T_a) @ last_axes(T_b, (4, 4), "T_b")
    corners = transform_points(T_a, a.common(own_from_other, b))
    found = least_width(corners)
    if found is None:
        return None
    depth, way = found
    at = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    apart = transform_points(T_b, b.centre[None])[0] - transform_points(T_a, a.centre[None])[0]
    return Reach(depth, way if way @ apart >= 0.0 else -way, at)


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
