"""Γ turned in its plane to where its own data say, so that how the camera was held decides nothing.

Boxes of votes, and the directions in which poses are tilted, have axes of their own. Here these go by the data: what is
found in a turned image is what was found, turned.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, fsum
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.data import centre_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]

NOWHERE = 1e-6
"""Share of their mean distance from the image's centre by which the mean of the data is off it, where it says of no
direction."""


def turn_of(data: Data, which: NDArray[np.bool_]) -> float:
    """Radians, clockwise on the screen from +x, to the mean of the data ``which`` (A,), from the image's centre; 0 where they have none.

    Their order decides nothing, to the last bit.
    """
    off = data.ideal[which] - centre_of(data.camera)
    x, y, far = (fsum(values.tolist()) for values in (*off.T, np.hypot(*off.T)))
    return atan2(y, x) if np.hypot(x, y) > NOWHERE * far else 0.0


def turned(data: Data, angle: float) -> Data:
    """Places in the ideal image, and angles, clockwise by ``angle``; what Γ itself says, in its own pixels, stays."""
    return replace(data, ideal=places_turned(data.ideal, centre_of(data.camera), angle), angle=data.angle + angle)


def places_turned(uv: Floats, centre: Floats, angle: float) -> Floats:
    """(N, 2) ideal pixels, clockwise about the ``centre`` (2,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = (uv - centre).T
    return np.column_stack([cos * x - sin * y, sin * x + cos * y]) + centre


def poses_turned(poses: Floats, angle: float) -> Floats:
    """camera_from_object (..., 4, 4) of the camera in whose image all is turned clockwise by ``angle``."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = poses[..., 0, :], poses[..., 1, :]
    return np.stack([cos * x - sin * y, sin * x + cos * y, poses[..., 2, :], poses[..., 3, :]], axis=-2)
