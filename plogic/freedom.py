"""What a pose owes to its freedom: of all poses a few fit any matches, so that a fit to them is no evidence by itself.

The evidence of presence is that of all poses, not of the best (the marginal likelihood, by Laplace's method): the likelihood at the best
pose, times the share of all poses that fit about as well.

* ``log_share(at, precision, centre, camera)``: the logarithm of that share, at most 0
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera

    Floats = NDArray[np.float64]

DEPTHS = 4.2
"""Logarithm of the ratio of the farthest to the nearest distance that is believed."""
LOOSE = (0.3, 0.35)
"""Even one appearance fixes the distance (its size) and the rotation (its angle and its lobe) so well: logarithm, radians."""


def log_share(at: Floats, precision: Floats, centre: Floats, camera: Camera) -> float:
    """The share of all poses, even in the image, in the logarithm of depth and in rotation, that fit matched places as well as theirs.

    ``at`` (N, 3) metres, camera frame; ``precision`` (N,) 1/pixel²; ``centre`` (3,) of the object, before the camera.
    """
    depth, arms = centre[2], at - centre
    slopes = np.zeros((len(at), 2, 6))
    moves = np.concatenate([np.broadcast_to(depth * np.eye(3), (len(at), 3, 3)), _crossing(arms)], axis=2)
    for row in (0, 1):
        slopes[:, row] = camera.f / at[:, 2:] * (moves[:, row] - at[:, row : row + 1] / at[:, 2:] * moves[:, 2])
    known = np.einsum("n,nki,nkj->ij", precision, slopes, slopes)
    known[np.arange(6), np.arange(6)] += np.array([*_image_bounds(camera), LOOSE[0], *[LOOSE[1]] * 3]) ** -2.0
    volume = 3.0 * np.log(2.0 * np.pi) - 0.5 * float(np.linalg.slogdet(known)[1])
    every = np.log(camera.width * camera.height / camera.f**2 * DEPTHS * 8.0 * np.pi**2)
    return min(0.0, float(volume - every))


def _image_bounds(camera: Camera) -> tuple[float, float]:
    return camera.width / camera.f, camera.height / camera.f


def _crossing(arms: Floats) -> Floats:
    """(N, 3, 3) matrices M with M w = w × arm."""
    x, y, z = arms.T
    zero = np.zeros(len(arms))
    return np.stack([np.stack([zero, z, -y], 1), np.stack([-z, zero, x], 1), np.stack([y, -x, zero], 1)], axis=1)
