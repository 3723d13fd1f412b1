"""Registering a photo to an object from a few clicked points: the pose, and the focal length where nobody knows it.

* ``register(points, uv, size)``: a ``Registration`` with ``camera``, ``camera_from_object``, ``residuals`` (N,) px,
  ``rms`` px
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.camera import NEAREST, Camera, centred_camera
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, transform_points
from geometry.poses.focal import CLICK, focal_fit
from geometry.poses.refine import refine_poses

LEAST_POINTS_CALIBRATED, LEAST_POINTS_UNCALIBRATED = 4, 6
"""Points that are needed with a camera, and without one: a pose has six numbers, a focal length is a seventh, a point
gives two."""
FOCAL_LENGTHS = (0.4, 8.0, 20)
"""Tried: least and greatest, as shares of the image's longer side, and how many."""
UNSURE = 0.05
"""Greatest standard error of the focal length, as its share, were all clicks as good as ``CLICK``: beyond, the points
lie too flat to tell it."""
FLAT = 1e-3
"""Points whose second extent is below this share of their first lie on a line."""

NOWHERE = "no pose has all points before the camera and on their pixels"


@dataclass(frozen=True, eq=False)
class Registration:
    """Where the object was when the photo was taken.

    Attributes:
        camera: The one given, or one with fx = fy, its centre at the image's.
        camera_from_object: (4, 4).
        residuals: (N,) px between each point's image and its click.
        rms: Their root mean square, px.
        f_error: Standard error of the focal length, px; 0 where the camera was given.
    """

    camera: Camera
    camera_from_object: Floats
    residuals: Floats
    rms: float
    f_error: float


def register(points: ArrayLike, uv: ArrayLike, size: tuple[int, int], camera: Camera | None = None) -> Registration:
    """The pose that reprojects `points` (N, 3) m nearest to the clicked pixels `uv` (N, 2).

    Without a camera, its focal length too.

    `size` is (width, height) px. Every pose that is a local best from any of many starts is tried; the best of them is
    taken.

    Raises:
        GeometryError: too few points, one that is not finite, all on a line, no pose with all points before the camera,
        or points that
            do not fix the focal length.
    """
    objects, seen = _checked(points, uv, LEAST_POINTS_UNCALIBRATED if camera is None else LEAST_POINTS_CALIBRATED)
    if camera is not None:
        return _registration(objects, seen, camera, _posed(objects, seen, camera)[0], 0.0)
    low, high, count = FOCAL_LENGTHS
    tried = [centred_camera(size, f) for f in np.geomspace(low, high, count) * max(size)]
    found = [(*_posed(objects, seen, some), some) for some in tried]
    pose, cost, start = min(found, key=lambda one: one[1])
    if not np.isfinite(cost):
        raise GeometryError(NOWHERE)
    fit = focal_fit(objects, seen, start, pose)
    f, pose, error = (
        start.f * float(np.exp(fit.log)),
        fit.pose,
        start.f * float(np.exp(fit.log)) * fit.noise * fit.error,
    )
    if not CLICK * fit.error < UNSURE:
        told = f"{f:.0f} +- {error:.0f} px" if np.isfinite(error) and 0 < f < 1e6 else "any would do"
        rule = "give the camera, or points on faces that differ more in direction, or clearly nearer and farther"
        raise GeometryError(f"the points do not fix the focal length ({told}): {rule}")
    return _registration(objects, seen, centred_camera(size, f), pose, error)


def suspect(points: ArrayLike, uv: ArrayLike, size: tuple[int, int], camera: Camera | None = None) -> int:
    """The index of the point that fits worst: without it the others fit best.

    Where too few would be left, that of the largest residual.
    """
    objects, seen = last_axes(points, (-1, 3), "points"), last_axes(uv, (-1, 2), "uv")
    whole = register(objects, seen, size, camera)
    if len(objects) <= (LEAST_POINTS_UNCALIBRATED if camera is None else LEAST_POINTS_CALIBRATED):
        return int(np.argmax(whole.residuals))
    f_known = whole.camera  # close enough to tell which point is off, and safe with a point less
    rests = [np.arange(len(objects)) != i for i in range(len(objects))]
    return int(np.argmin([_posed(objects[rest], seen[rest], f_known)[1] for rest in rests]))


def _checked(points: ArrayLike, uv: ArrayLike, fewest: int) -> tuple[Floats, Floats]:
    objects, seen = last_axes(points, (-1, 3), "points"), last_axes(uv, (-1, 2), "uv")
    if objects.ndim != 2 or seen.ndim != 2 or len(objects) != len(seen):
        raise GeometryError(f"points (N, 3) and uv (N, 2) must agree in N, not {objects.shape} and {seen.shape}")
    if len(objects) < fewest:
        raise GeometryError(
            f"{len(objects)} points are too few: {LEAST_POINTS_CALIBRATED} at least with a camera, {LEAST_POINTS_UNCALIBRATED} without"
        )
    bad = np.flatnonzero(~(np.isfinite(objects).all(axis=1) & np.isfinite(seen).all(axis=1)))
    if len(bad):
        raise GeometryError(f"point {bad[0] + 1} is not finite")
    for what, places in (("points", objects), ("pixels", seen)):
        extents = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        if not extents[1] > FLAT * extents[0]:
            raise GeometryError(f"all {what} lie on one line: they fix no pose")
    return objects, seen


def _posed(objects: Floats, seen: Floats, camera: Camera) -> tuple[Floats, float]:
    """The best pose (4, 4) from starts all around, and its rms, px; inf where all have points behind the camera."""
    starts = _starts(objects, seen, camera)
    count = len(starts)
    many = np.broadcast_to(objects, (count, *objects.shape)), np.broadcast_to(seen, (count, *seen.shape))
    poses, rms, _ = refine_poses(starts, *many, np.ones((count, len(objects))), camera, 30)
    best = int(np.argmin(rms))
    return np.asarray(poses[best]), float(rms[best])


def _starts(objects: Floats, seen: Floats, camera: Camera) -> Floats:
    """(72, 4, 4) poses: the object turned every way, all of it in front.

    Its middle is that of the clicks, at the distance that its size tells.
    """
    from scipy.spatial.transform import Rotation

    turns = (Rotation.create_group("O") * Rotation.from_rotvec([0.4, 0.3, 0.2])).as_matrix()
    nods = Rotation.from_rotvec([[0, 0, 0], [0.7, 0, 0], [0, 0.7, 0]]).as_matrix()
    rotations = (nods[:, None] @ turns[None]).reshape(-1, 3, 3)
    middle, rays = objects.mean(axis=0), camera.normalised(seen)
    spread = np.sqrt(((rays - rays.mean(axis=0)) ** 2).sum(axis=1).mean())
    extent = np.sqrt(((objects - middle) ** 2).sum(axis=1).mean())
    depth = max(extent / max(spread, 1e-9), 1.5 * float(np.linalg.norm(objects - middle, axis=1).max()))
    place = np.append(rays.mean(axis=0), 1.0) * depth
    return from_rotation_translation(rotations, place - rotations @ middle)


def _registration(objects: Floats, seen: Floats, camera: Camera, pose: Floats, error: float) -> Registration:
    placed = transform_points(pose, objects)
    if not (placed[:, 2] > NEAREST).all():
        raise GeometryError(NOWHERE)
    residuals = np.linalg.norm(camera.project(placed) - seen, axis=1)
    if not np.isfinite(residuals).all():
        raise GeometryError(NOWHERE)
    return Registration(camera, pose, residuals, float(np.sqrt((residuals**2).mean())), error)
