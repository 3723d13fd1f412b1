"""Points along edges: where print, labels and outlines are, also those too small, too oblique or too plain for blobs and corners.

A blob detector finds a place and a size that come again; of an object a hundred pixels tall it finds few. An edge comes again nearly
always, though where along it a point lies is arbitrary: points are therefore taken densely, and their surroundings are described at one
small size, turned by the gradient.

* ``EdgePoints``: N of them as arrays, the strongest first
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SMOOTH = 1.0
"""Pixels, standard deviation: noise below this size makes no edge."""
LEAST = 1.5
"""Grey levels a pixel that an edge must rise."""
BORDER = 5
"""Pixels of the image's margin without edges: as far as blur and slope reach."""


@dataclass(frozen=True)
class EdgePoints:
    """``uv`` (N, 2) pixels; ``angle`` (N,) radians of the gradient, from dark to bright, clockwise from +x; ``rise`` (N,) grey levels a pixel."""

    uv: Floats
    angle: Floats
    rise: Floats


def edge_points(grey: NDArray[np.uint8], cell: int, most: int) -> EdgePoints:
    """The strongest point of an edge in each square cell of an (H, W) image, ``cell`` pixels wide; at most ``most``, the strongest first.

    A point is where the gradient is greatest along its own direction, to a part of a pixel.
    """
    import cv2

    if min(grey.shape) <= 2 * BORDER:
        return EdgePoints(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    smooth = np.asarray(cv2.GaussianBlur(grey.astype(np.float32), (0, 0), SMOOTH))
    gx, gy = (np.asarray(cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3)) / 8.0 for order in ((1, 0), (0, 1)))
    rise = np.hypot(gx, gy)
    inner = np.zeros(grey.shape, bool)
    inner[BORDER:-BORDER, BORDER:-BORDER] = True
    y, x = np.nonzero((rise > LEAST) & inner)
    here = rise[y, x].astype(float)
    across = np.column_stack([gx[y, x], gy[y, x]]) / here[:, None]
    ahead, behind = (_between(rise, np.column_stack([x, y]) + sign * across) for sign in (1.0, -1.0))
    ridge = (here >= ahead) & (here > behind)
    x, y, here, across, ahead, behind = (values[ridge] for values in (x, y, here, across, ahead, behind))
    bend = np.minimum(ahead + behind - 2.0 * here, -1e-6)
    uv = np.column_stack([x, y]) + np.clip(0.5 * (behind - ahead) / bend, -0.5, 0.5)[:, None] * across
    order = np.argsort(-here, kind="stable")
    cells = (y[order] // cell) * grey.shape[1] + x[order] // cell
    best = order[np.sort(np.unique(cells, return_index=True)[1])[:most]]
    return EdgePoints(uv[best], np.arctan2(across[best, 1], across[best, 0]), here[best])


def _between(values: NDArray[np.float32], at: Floats) -> Floats:
    """(N,) of an (H, W) array between its pixels, at places (N, 2) inside it."""
    x, y = np.floor(at).astype(np.intp).T
    a, b = (at - np.floor(at)).T
    upper = values[y, x] * (1.0 - a) + values[y, x + 1] * a
    lower = values[y + 1, x] * (1.0 - a) + values[y + 1, x + 1] * a
    return np.asarray(upper * (1.0 - b) + lower * b)
