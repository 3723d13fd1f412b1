"""Where appearances carry depth (a stereo pair is one notional viewpoint, §3.3), depths fix poses.

They do not decide what is matched: some are wrong, where a feature was missed in one image and another that looks like
it in the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.camera import Camera
from geometry.frames import transform_points
from geometry.poses.refine_sights import Sight, refine_sights

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]

DEVIATIONS, SHARE = 4.0, 0.05
"""A depth counts that is off a pose's by so many standard deviations at most, or by this share of it."""
BASELINE = 1000.0
"""Depths between the camera and one far to the side, whose pixels then tell the depth and nothing else."""


def with_depths(
    pose: Floats, seen: Sight, points: Floats, datum: NDArray[np.intp], data: Data, *, sigma: float, huber: float
) -> Floats:
    """The pose (4, 4), camera_from_object, that fits what is ``seen`` of it and the depths of ``datum`` (N,), matched with ``points`` (N, 3) m.

    As it was where none has a depth. ``sigma``: the noise of places, pixels, for which the weights of what is seen
    stand, in whatever unit. ``huber``: pixels beyond which a residual counts linearly.
    """
    told = side_sight(pose, points, datum, data, sigma)
    if told is None:
        return pose
    unit = float(np.median(seen.weights)) * sigma**2
    return refine_sights(pose, [seen, told._replace(weights=unit * told.weights)], huber=huber)


def side_sight(pose: Floats, points: Floats, datum: NDArray[np.intp], data: Data, sigma: float) -> Sight | None:
    """The depths of ``datum`` (N,) as what a camera far to the side sees of ``points`` (N, 3), with noise of about ``sigma`` pixels.

    Weights are 1/variance. None where no depth is told that could be right at this ``pose`` (4, 4).
    """
    if data.depth is None or data.depth_sigma is None:
        return None
    here = transform_points(pose, points)[:, 2]
    known = np.abs(data.depth[datum] - here) <= np.maximum(DEVIATIONS * data.depth_sigma[datum], SHARE * here)
    if not known.any():
        return None
    depth, spread = data.depth[datum][known], data.depth_sigma[datum][known]
    aside = BASELINE * float(np.median(depth))
    focal = float(np.median(depth**2 / spread)) / aside * sigma
    camera = Camera(2, 2, np.array([[focal, 0.0, 0.0], [0.0, focal, 0.0], [0.0, 0.0, 1.0]]))
    moved = np.eye(4)
    moved[0, 3] = -aside
    ray = data.camera.normalised(data.uv[datum][known])
    uv = focal * np.stack([ray[:, 0] - aside / depth, ray[:, 1]], axis=1)
    noise = focal * aside * spread / depth**2
    across = np.broadcast_to([1.0, 0.0], uv.shape)
    return Sight(camera, moved, points[known], uv, 1.0 / noise**2, across)
