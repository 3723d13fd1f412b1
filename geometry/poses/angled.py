"""What the angle of a feature on the screen says of a pose: the way to a point along the x axis of its frame must lie on the datum's line.

* ``ends(points, axes, depth, length)``: those points, in any frame; ``across(angle)``: unit vectors across the lines
"""

import numpy as np

from geometry.arrays import Floats

ARM = 2.0
"""The point is so far away, on the screen, that the noise of the angle moves it by so many times the noise of a
place."""
WEIGHT = 1.0 / (1.0 + ARM**2)
"""How much it weighs beside a place: its own place is off by the noise of the feature's and, ``ARM`` times as far, by
that of the angle."""


def reach(pixels: Floats, angle: float) -> Floats:
    """(...,) how far away the point is, pixels, at a noise of places ``pixels`` (...,), and of angles, radians."""
    return ARM * pixels / angle


def ends(points: Floats, axes: Floats, depth: Floats, length: Floats) -> Floats:
    """(..., 3) m, the points along unit ``axes`` (..., 3) from ``points`` (..., 3), in the frame of both.

    ``depth`` (...,) m of the points before the camera; ``length`` (...,) pixels over the focal length.
    """
    return points + (length * np.maximum(depth, 0.0))[..., None] * axes


def across(angle: Floats) -> Floats:
    """(..., 2) unit vectors across lines at angles (...,), radians clockwise on the screen."""
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
