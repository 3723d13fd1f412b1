"""Whether matched points agree with the camera's focal length, the pose being free.

A wrong focal length is made up for by another depth, but not wholly: what is nearer is drawn larger.
"""

import numpy as np

from geometry.arrays import Floats
from geometry.camera import NEAREST, Camera
from geometry.frames import transform_points

CLICK = 0.5
"""Least standard deviation of a place in the image, px, whatever the residuals say."""
FEWEST = 6
"""Points below which nothing is said: seven numbers are free."""


def focal_step(points: Floats, uv: Floats, camera: Camera, pose: Floats) -> tuple[float, float]:
    """(step, error): by how much ln f should change for ``points`` (N, 3) m, object frame, to fit ``uv`` (N, 2) px.

    The first step of Gauss and Newton from a ``pose`` (4, 4) that is the best for the stated f, all seven numbers free,
    and its standard error as the residuals that are left tell it; (0, inf) where the points fix nothing.
    """
    placed = transform_points(pose, points)
    if len(points) < FEWEST or not (placed[:, 2] > NEAREST).all():
        return 0.0, np.inf
    f, depth = camera.f, placed[:, 2]
    xy = placed[:, :2] / depth[:, None]
    off = f * (xy - camera.normalised(uv))
    by_place = np.zeros((len(points), 2, 3))
    by_place[:, 0, 0] = by_place[:, 1, 1] = f / depth
    by_place[:, :, 2] = -f * xy / depth[:, None]
    by_turn = by_place @ np.moveaxis(np.cross(np.eye(3), placed[:, None]), 1, 2)
    table = np.concatenate([f * xy[:, :, None], by_turn, by_place], axis=2).reshape(-1, 7)
    size = np.linalg.norm(table, axis=0)
    left, values, right = np.linalg.svd(table / np.where(size > 0.0, size, 1.0), full_matrices=False)
    if not np.isfinite(off).all() or values[-1] <= 1e-9 * values[0]:
        return 0.0, np.inf
    step = -(right.T / values) @ (left.T @ off.ravel())
    rest = off.ravel() + (table / size) @ step
    noise = max(float(np.sqrt((rest**2).sum() / max(len(rest) - 7, 1))), CLICK)
    return float(step[0] / size[0]), float(noise * np.sqrt(((right[:, 0] / values) ** 2).sum()) / size[0])
