"""What BOP says of an object's picture besides its pose: silhouette, visible part, their boxes and the visible fraction.

The silhouette is what rays through the pixels' centres hit of the object alone, on a canvas three times as wide and
high as the image, so that what the image's border cuts off counts as hidden; the visible part is the rendering's own
segmentation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import inverse, rotate, transform_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from geometry.visibility.rays import RayMesh

Box = list[int]
NOTHING: Box = [-1, -1, -1, -1]


@dataclass(frozen=True, eq=False)
class Silhouette:
    """``mask`` (H, W): the part in the image; ``pixels`` and ``box`` (x, y, width, height) of all of it, beyond the border too."""

    mask: NDArray[np.bool_]
    pixels: int
    box: Box


def silhouette(shape: RayMesh, camera_from_object: NDArray[np.float64], camera: Camera) -> Silhouette:
    """The picture of one object alone; of one that is not before the camera, nothing."""
    mask = np.zeros((camera.height, camera.width), dtype=bool)
    u, v = _grid(transform_points(camera_from_object, shape.vertices), camera)
    rays = camera.rays(np.stack([u, v], axis=-1).astype(np.float64))
    object_from_camera = inverse(camera_from_object)
    hit = np.isfinite(shape.first_hit(object_from_camera[None, :3, 3], rotate(object_from_camera, rays)))
    u, v = u[hit], v[hit]
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    mask[v[inside], u[inside]] = True
    return Silhouette(mask, len(u), box_of(u, v))


def _grid(points_camera: NDArray[np.float64], camera: Camera) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The pixels (N,), (N,) of the canvas that points' images lie among; all of it where a point has no image."""
    uv = camera.project(points_camera)
    size = np.array([camera.width, camera.height])
    known = bool(np.isfinite(uv).all())
    low = np.clip(np.floor(uv.min(axis=0)), -size, 2 * size - 1) if known else -size
    high = np.clip(np.ceil(uv.max(axis=0)), -size, 2 * size - 1) if known else 2 * size - 1
    u, v = np.meshgrid(np.arange(int(low[0]), int(high[0]) + 1), np.arange(int(low[1]), int(high[1]) + 1))
    return u.ravel(), v.ravel()


def box_of(u: NDArray[Any], v: NDArray[Any]) -> Box:
    """BOP's box (x, y, width, height) of pixels; -1 for none. As in the benchmark the width is the last column minus the first."""
    if not len(u):
        return list(NOTHING)
    return [int(u.min()), int(v.min()), int(u.max() - u.min()), int(v.max() - v.min())]


def gt_info(whole: Silhouette, visible: NDArray[np.bool_], measured: NDArray[np.bool_]) -> dict[str, Any]:
    """One entry of ``scene_gt_info.json``; ``visible`` and ``measured`` (H, W): the object's pixels, and those that have a depth.

    A visible pixel at the edge that no ray has hit counts as the silhouette's.
    """
    extra = int((visible & ~whole.mask).sum())
    everything, seen = whole.pixels + extra, int(visible.sum())
    v, u = np.nonzero(visible)
    return {
        "bbox_obj": whole.box,
        "bbox_visib": box_of(u, v),
        "px_count_all": everything,
        "px_count_valid": int((measured & (whole.mask | visible)).sum()),
        "px_count_visib": seen,
        "visib_fract": seen / everything if everything else 0.0,
    }
