"""Behind(y, x, v): the line of sight from v to y meets x strictly before y (formalism §3.4)."""

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Mask, last_axes
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import RayMesh

TOLERANCE = 0.005  # of the surface's size: a feature's own facets at the feature do not hide it


def behind(
    points_camera: ArrayLike, mesh: RayMesh, camera_from_object: ArrayLike, tolerance: float | None = None
) -> Mask:
    """Mask (N,) of the `points_camera` (N, 3) m that the surface `mesh`, posed, hides from the camera's centre.

    The points go into the surface's own frame, so one structure serves every pose of a type. `tolerance` (m) is how far
    before a point the surface must be met, by default 0.005 of the surface's size. NaN points are behind nothing.
    """
    object_from_camera = inverse(last_axes(camera_from_object, (4, 4), "camera_from_object"))
    margin = TOLERANCE * mesh.size if tolerance is None else tolerance
    return mesh.blocks(
        object_from_camera[:3, 3], transform_points(object_from_camera, np.asarray(points_camera)), margin
    )
