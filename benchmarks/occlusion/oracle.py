"""The oracle: dense rays over both bodies' boxes.

What a raster can tell of the relation, and nothing where it hangs on a few rays.

A raster cannot tell DC from EC, nor TPP from NTPP and EQ, at less than its grain. It decides a pair only where every
question it asks is answered by ``FEW`` rays or more, or by none within ``MARGIN`` rays: then there is one relation that
it allows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.occlusion.bodies import CAMERA
from geometry.frames import transform_points
from geometry.visibility.occlusion import DEPTH_TOLERANCE
from geometry.visibility.roc import Front, Roc, roc

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.visibility.occlusion import PosedSurface
    from geometry.visibility.roc import Rcc8

    Mask = NDArray[np.bool_]

LINES, FINE = 80, 400
"""Rays along each side of the grid: at first, and where the first answer is not ours."""
FEW = 6
"""Rays that a yes takes."""
MARGIN = 2
"""Rays within which there must be none for a no."""


def raster_relation(x: PosedSurface, y: PosedSurface, lines: int = LINES) -> Roc | None:
    """The relation of x to y, or None where the raster does not decide it."""
    rays = CAMERA.rays(_grid(x, y, lines))
    depth_x, depth_y = (s.depth(rays).reshape(lines, lines) for s in (x, y))
    on_x, on_y = np.isfinite(depth_x), np.isfinite(depth_y)
    common = on_x & on_y
    if not common.any():
        return None if (_wide(on_x) & on_y).any() or not (on_x.any() and on_y.any()) else "non_occludes_dc"
    front = _front(common, depth_x, depth_y)
    term = _term(on_x, on_y)
    return None if front is None or term is None or common.sum() < FEW else roc(term, front)


def _front(common: Mask, depth_x: NDArray[np.float64], depth_y: NDArray[np.float64]) -> Front | None:
    gap = np.where(common, depth_x, 0.0) - np.where(common, depth_y, 0.0)
    margin = DEPTH_TOLERANCE * np.minimum(np.where(common, depth_x, 0.0), np.where(common, depth_y, 0.0))
    x_first, y_first = int((gap < -margin).sum()), int((gap > margin).sum())
    if 0 < x_first < FEW or 0 < y_first < FEW:
        return None
    if x_first and y_first:
        return "both"
    return "x" if x_first else "y" if y_first else None


def _term(on_x: Mask, on_y: Mask) -> Rcc8 | None:
    out_x, out_y = _sticks_out(on_x, on_y), _sticks_out(on_y, on_x)
    if out_x is None or out_y is None or not (out_x or out_y):
        return None
    if out_x and out_y:
        return "PO"
    return "NTPPi" if out_x else "NTPP"


def _sticks_out(one: Mask, other: Mask) -> bool | None:
    """Whether ``one`` reaches farther out of ``other`` than the margin.

    None where it comes near the edge of it and no farther.
    """
    if (one & ~_wide(other)).sum() >= FEW:
        return True
    return None if (_wide(one) & ~other).any() else False


def _wide(mask: Mask) -> Mask:
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(mask, np.ones((3, 3), bool), iterations=MARGIN))


def _grid(x: PosedSurface, y: PosedSurface, lines: int) -> NDArray[np.float64]:
    """Pixels (lines², 2) over the box of both images and a margin; of what reaches behind the camera, nothing."""
    seen = np.concatenate([CAMERA.project(transform_points(s.camera_from_object, s.vertices)) for s in (x, y)])
    low, high = np.nanmin(seen, axis=0), np.nanmax(seen, axis=0)
    rim = (MARGIN + 1) * (high - low) / lines
    across, down = (np.linspace(low[i] - rim[i], high[i] + rim[i], lines) for i in range(2))
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
