"""Least squares on places and angles: an angle tells how a feature is turned in space, most where its x axis leads out of the image plane."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.refine import refine_poses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera

    Floats = NDArray[np.float64]

ARM = 2.0
"""An angle is the way to a point along the x axis of the feature's frame, which must lie on the datum's line: so far away, on the screen, that the
noise of the angle moves it by so many times the noise of a place."""


class Noise(NamedTuple):
    """Standard deviations: ``pixels`` of a datum's place along one axis, ``angle`` of its angle, radians."""

    pixels: float
    angle: float


class Held(NamedTuple):
    """V matches that hold each of N poses.

    ``points``, ``turns`` (N, V, 3) places and x axes of the features, object frame; ``uv`` (N, V, 2) pixels, ``angle`` (N, V) rad, NaN where a
    datum has none; ``weight`` (N, V), 0 where there is no match, else 1, or more where a place is more exact.
    """

    points: Floats
    turns: Floats
    uv: Floats
    angle: Floats
    weight: Floats


def refined(poses: Floats, held: Held, noise: Noise, camera: Camera, *, steps: int, robust: float) -> Floats:
    """(N, 4, 4) from poses (N, 4, 4); a residual beyond ``robust`` times the noise of places weighs less."""
    points, uv, weight, across = met(poses, held, noise, camera)
    return np.asarray(refine_poses(poses, points, uv, weight, camera, steps, huber=robust * noise.pixels, across=across)[0])


def met(poses: Floats, held: Held, noise: Noise, camera: Camera) -> tuple[Floats, Floats, Floats, Floats]:
    """What poses (N, 4, 4) are to meet, of places and then of angles, as ``refine_poses`` takes it.

    Points (N, 2 V, 3) m, pixels (N, 2 V, 2), weights (N, 2 V) 1/pixel², and unit vectors across lines (N, 2 V, 2).
    """
    sided = np.isfinite(held.angle) & (held.weight > 0.0)
    line = np.where(sided, held.angle, 0.0)
    at = np.einsum("nij,nvj->nvi", poses[:, :3, :3], held.points) + poses[:, None, :3, 3]
    length = ARM * noise.pixels / noise.angle
    ends = held.points + (length * np.maximum(at[..., 2], 0.0) / camera.f)[..., None] * held.turns
    across = np.stack([-np.sin(line), np.cos(line)], axis=2)
    return (
        np.concatenate([held.points, ends], axis=1),
        np.concatenate([held.uv, held.uv], axis=1),
        np.concatenate([held.weight, held.weight * sided / (1.0 + ARM**2)], axis=1) / noise.pixels**2,
        np.concatenate([np.full(across.shape, np.nan), across], axis=1),
    )
