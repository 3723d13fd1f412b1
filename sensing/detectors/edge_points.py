"""Points along edges: where print, labels and outlines are, also those too small, too oblique or too plain for blobs and corners.

A blob detector finds a place and a size that come again; of an object a hundred pixels tall it finds few. An edge comes
again nearly always, though where along it a point lies is arbitrary: points are therefore taken densely, and their
surroundings are described at one small size, turned by the gradient.

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


def edge_points(image: NDArray[np.uint8], cell: int, most: int, least: float = LEAST) -> EdgePoints:
    """The strongest point of an edge in each square cell of an image, ``cell`` pixels wide; at most ``most``, the strongest first.

    It rises by more than ``least`` grey levels a pixel. A point is where the gradient is greatest along its own
    direction, to a part of a pixel. Of an image (H, W, 3) the gradient is that of the channel in which it is greatest,
    so that colours of one brightness have an edge between them too.
    """
    if min(image.shape[:2]) <= 2 * BORDER:
        return EdgePoints(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    gx, gy = _gradient(image)
    rise = np.hypot(gx, gy)
    inner = np.zeros(rise.shape, bool)
    inner[BORDER:-BORDER, BORDER:-BORDER] = True
    y, x = np.nonzero((rise > least) & inner)
    here = rise[y, x].astype(float)
    across = np.column_stack([gx[y, x], gy[y, x]]) / here[:, None]
    ahead, behind = (_between(rise, np.column_stack([x, y]) + sign * across) for sign in (1.0, -1.0))
    ridge = (here >= ahead) & (here > behind)
    x, y, here, across, ahead, behind = x[ridge], y[ridge], here[ridge], across[ridge], ahead[ridge], behind[ridge]
    bend = np.minimum(ahead + behind - 2.0 * here, -1e-6)
    uv = np.column_stack([x, y]) + np.clip(0.5 * (behind - ahead) / bend, -0.5, 0.5)[:, None] * across
    order = np.argsort(-here, kind="stable")
    cells = (y[order] // cell) * rise.shape[1] + x[order] // cell
    best = order[np.sort(np.unique(cells, return_index=True)[1])[:most]]
    return EdgePoints(uv[best], np.arctan2(across[best, 1], across[best, 0]), here[best])


def _gradient(image: NDArray[np.uint8]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(H, W) grey levels a pixel along x and y."""
    import cv2

    smooth = np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTH), np.float32)
    gx, gy = (
        np.asarray(cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3) / 8.0, np.float32) for order in ((1, 0), (0, 1))
    )
    if image.ndim == 2:
        return gx, gy
    steepest = (gx * gx + gy * gy).argmax(axis=2)[..., None]
    return np.take_along_axis(gx, steepest, 2)[..., 0], np.take_along_axis(gy, steepest, 2)[..., 0]


def _between(values: NDArray[np.float32], at: Floats) -> Floats:
    """(N,) of an (H, W) array between its pixels, at places (N, 2) inside it."""
    x, y = np.floor(at).astype(np.intp).T
    a, b = (at - np.floor(at)).T
    upper = values[y, x] * (1.0 - a) + values[y, x + 1] * a
    lower = values[y + 1, x] * (1.0 - a) + values[y + 1, x + 1] * a
    return np.asarray(upper * (1.0 - b) + lower * b)
