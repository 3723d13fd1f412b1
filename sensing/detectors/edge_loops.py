# ruff: noqa: ANN401 - what is compiled takes arrays of several types
"""The loop over the pixels of edges, compiled (numba) when it is first called, and kept on disk."""

from typing import Any

import numpy as np

from sensing.compiled import compiled


@compiled()
def ridges(gx: Any, gy: Any, inner: Any, least: float, cell: int) -> Any:
    """The strongest pixel of each square cell of an image that is on the ridge of an edge, cell by cell.

    ``gx``, ``gy`` (H, W, C): float32 grey levels a pixel along x and y in each channel; that which rises most counts.
    A ridge rises by more than ``least`` and is where ``inner`` (H, W) holds, off the rims. (N, 7) float64: pixel x, y;
    its rise; the unit direction in which it rises; the rise a pixel ahead and one behind.
    """
    height, width, channels = gx.shape
    rise, chosen = np.empty((height, width), np.float32), np.zeros((height, width), np.uint8)
    for y in range(height):
        for x in range(width):
            best = np.float32(-1.0)
            for k in range(channels):
                square = gx[y, x, k] * gx[y, x, k] + gy[y, x, k] * gy[y, x, k]
                if square > best:
                    best, chosen[y, x] = square, k
            rise[y, x] = np.sqrt(best)
    columns = (width + cell - 1) // cell
    found = np.zeros(((height + cell - 1) // cell * columns, 7))
    for y in range(height):
        for x in range(width):
            here, number = np.float64(rise[y, x]), y // cell * columns + x // cell
            if here > least and inner[y, x] and here > found[number, 2]:
                k = chosen[y, x]
                right, down = gx[y, x, k] / here, gy[y, x, k] / here
                ahead = between(rise, x + right, y + down)
                behind = between(rise, x - right, y - down)
                if here >= ahead and here > behind:
                    for i, value in enumerate((float(x), float(y), here, right, down, ahead, behind)):
                        found[number, i] = value
    return found[found[:, 2] > 0.0]


@compiled()
def between(values: Any, x: float, y: float) -> float:
    """Of an (H, W) array what is between its pixels, inside it."""
    i, j = int(np.floor(x)), int(np.floor(y))
    a, b = x - i, y - j
    upper = values[j, i] * (1.0 - a) + values[j, i + 1] * a
    lower = values[j + 1, i] * (1.0 - a) + values[j + 1, i + 1] * a
    return float(upper * (1.0 - b) + lower * b)
