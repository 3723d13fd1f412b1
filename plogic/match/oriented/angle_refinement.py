"""Least squares on places and angles: an angle tells how a feature is turned in space, most where its x axis leads out of the image plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.refine import Steps, refined_poses
from geometry.poses.reprojection import WEIGHT, across, ends, reach

if TYPE_CHECKING:
    from geometry.arrays import Floats
    from geometry.camera import Camera


class Noise(NamedTuple):
    """Standard deviations: ``pixels`` of a datum's place along one axis, ``angle`` of its angle, radians."""

    pixels: float
    angle: float


class Held(NamedTuple):
    """V matches that hold each of N poses.

    ``points``, ``turns`` (N, V, 3) places and x axes of the features, object frame; ``uv`` (N, V, 2) pixels, ``angle``
    (N, V) rad, NaN where a datum has none; ``weight`` (N, V), 0 where there is no match, else 1, or more where a place
    is more exact.
    """

    points: Floats
    turns: Floats
    uv: Floats
    angle: Floats
    weight: Floats


def refined(
    poses: Floats,
    held: Held,
    noise: Noise,
    camera: Camera,
    *,
    steps: int,
    robust: float | None = None,
    sigma: Floats | None = None,
) -> Floats:
    """(N, 4, 4) from poses (N, 4, 4); a residual beyond ``robust`` times the noise of places weighs less.

    ``sigma`` (N,): the noise of places of each pose, pixels, in place of that of all.
    """
    points, uv, weight, lines = met(poses, held, noise, camera, sigma)
    huber = None if robust is None else robust * noise.pixels
    return refined_poses(poses, points, uv, weight, camera, Steps(steps), huber=huber, across=lines)


def met(
    poses: Floats, held: Held, noise: Noise, camera: Camera, sigma: Floats | None = None
) -> tuple[Floats, Floats, Floats, Floats]:
    """What poses (N, 4, 4) are to meet, of places and then of angles, as ``refined_poses`` takes it.

    ``sigma`` as in ``refined``.

    Points (N, 2 V, 3) m, pixels (N, 2 V, 2), weights (N, 2 V) 1/pixel², and unit vectors across lines (N, 2 V, 2).
    """
    pixels = np.full((len(poses), 1), noise.pixels) if sigma is None else sigma[:, None]
    sided = np.isfinite(held.angle) & (held.weight > 0.0)
    lines = across(np.where(sided, held.angle, 0.0))
    depth = np.einsum("nj,nvj->nv", poses[:, 2, :3], held.points) + poses[:, None, 2, 3]
    return (
        np.concatenate(
            [held.points, ends(held.points, held.turns, depth, reach(pixels, noise.angle) / camera.f)], axis=1
        ),
        np.concatenate([held.uv, held.uv], axis=1),
        np.concatenate([held.weight, held.weight * sided * WEIGHT], axis=1) / pixels**2,
        np.concatenate([np.full(lines.shape, np.nan), lines], axis=1),
    )
