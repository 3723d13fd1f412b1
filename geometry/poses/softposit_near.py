"""SoftPOSIT as a refiner: from one near pose to a better one, with correspondences that nobody knows (formalism §6.2)."""

import numpy as np
from numpy.typing import ArrayLike

from geometry.errors import GeometryError
from geometry.poses.softposit import Annealing, SoftPositResult, softposit


def softposit_near(
    pose: ArrayLike,
    points: ArrayLike,
    xy: ArrayLike,
    *,
    off: float,
    allowed: ArrayLike | None = None,
    noise: float = 0.5,
    pixel: float = 1 / 600,
) -> SoftPositResult:
    """A better `camera_from_object` than `pose` (4, 4) of `points` (N, 3) m, some of which are seen among `xy` (M, 2) = x/z, y/z.

    `off`: about how many pixels off the points are at the start; beta begins at 1 / off^2, for a smaller one forgets
    the pose that it is given. `allowed` (N, M): which point may be which, any if not given; `noise` of an image point,
    px; `pixel`, in normalised units: 1 / focal length. The result is of one start: its pose means nothing unless it
    `converged`, and may be wrong then (its `count` of matches tells).

    Raises:
        GeometryError: where `off` is not above 0, or as `softposit` does.
    """
    if not off > 0:
        raise GeometryError(f"off must be above 0 pixels, not {off}")
    usual = Annealing(noise=noise, pixel=pixel)
    setting = Annealing(beta=min(1.0 / off**2, usual.beta_final), noise=noise, pixel=pixel)
    return softposit(points, xy, np.asarray(pose, dtype=np.float64)[None], allowed=allowed, annealing=setting)
