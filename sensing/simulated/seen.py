"""How much of each body a camera sees, by rays: the share of its own picture that the others leave visible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse, transform_points
from geometry.visibility.rays import RayMesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.simulated.body import Body

STEP = 2
"""Pixels between neighbouring rays."""


def seen_fractions(bodies: Sequence[Body], camera: Camera) -> tuple[float, ...]:
    """Per body: what is seen of it over what would be seen of it alone, both within the image; 0 where it is not in the image."""
    columns, rows = np.arange(0, camera.width, STEP), np.arange(0, camera.height, STEP)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    rays = np.c_[pixels, np.ones(len(pixels))] @ np.linalg.inv(camera.K).T
    depths = np.stack([_depths(body, camera, pixels, rays) for body in bodies])
    alone = np.isfinite(depths).sum(axis=1)
    first = np.where(np.isfinite(depths).any(axis=0), depths.argmin(axis=0), -1)
    return tuple(float((first == i).sum() / n) if n else 0.0 for i, n in enumerate(alone))


def bounds(body: Body, camera: Camera) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and the greatest (2,) pixel of the body's picture; not finite where some of it is behind the camera."""
    uv = camera.project(transform_points(inverse(np.asarray(camera.world_from_camera)), body.vertices_world))
    if not np.isfinite(uv).all():
        return np.full(2, -np.inf), np.full(2, np.inf)
    return uv.min(axis=0), uv.max(axis=0)


def _depths(body: Body, camera: Camera, pixels: NDArray[np.int64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) distances to this body alone; inf for none."""
    low, high = bounds(body, camera)
    near = ((pixels >= low - 1) & (pixels <= high + 1)).all(axis=1)
    found = np.full(len(pixels), np.inf)
    if near.any():
        mesh = RayMesh(body.vertices_world, body.mesh.triangles)
        pose = np.asarray(camera.world_from_camera)
        found[near] = mesh.first_hit(pose[None, :3, 3], rays[near] @ pose[:3, :3].T)
    return found
