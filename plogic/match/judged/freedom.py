"""What a pose owes to its freedom: of all poses a few fit any matches, so that a fit to them is no evidence by itself.

The evidence of presence is that of all poses, not of the best (the marginal likelihood, by Laplace's method): the
likelihood at the best pose, times the share of all poses that fit about as well.

* ``log_share(at, precision, centre, camera, across)``: the logarithm of that share, at most 0; ``share_of(information,
  ...)``, of what is known
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.reprojection import information

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera

    Floats = NDArray[np.float64]

DEPTHS = 4.2
"""Logarithm of the ratio of the farthest to the nearest distance that is believed."""
LOOSE = (0.3, 0.35)
"""Even one appearance fixes the distance (its size) and the rotation (its angle and its lobe) so well: logarithm,
radians."""


def log_share(at: Floats, precision: Floats, centre: Floats, camera: Camera, across: Floats | None = None) -> float:
    """The share of all poses, even in the image, in the logarithm of depth and in rotation, that fit matched places as well as theirs.

    ``at`` (N, 3) metres, camera frame; ``precision`` (N,) 1/pixel²; ``centre`` (3,) of the object, before the camera;
    ``across`` (N, 2) unit vectors across the edges that sides lie anywhere along, NaN of others.
    """
    return float(share_of(information(at, centre, precision, camera, across), centre[2], camera))


def share_of(information: Floats, depth: Floats | float, camera: Camera) -> Floats:
    """The logarithm of that share, (...,): of what is known (..., 6, 6) of a step (w rad, v m) in the camera's axes.

    The step is about a middle at ``depth`` (...,) metres.
    """
    far = np.asarray(depth, float)[..., None]
    scale = np.concatenate(
        [np.ones((*far.shape[:-1], 3)), np.repeat(far, 3, axis=-1)], axis=-1
    )  # moves are counted in depths
    loose = np.array([*[LOOSE[1]] * 3, camera.width / camera.f, camera.height / camera.f, LOOSE[0]])
    sharp = information * scale[..., :, None] * scale[..., None, :] + np.diag(loose**-2.0)
    volume = 3.0 * np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(sharp)[1]
    return np.asarray(volume - np.log(camera.width * camera.height / camera.f**2 * DEPTHS * 8.0 * np.pi**2))
