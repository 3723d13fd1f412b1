# ruff: noqa: ANN401 - what is compiled takes arrays of several types
"""Triangles filled with their texture, compiled (numba) when they are first called, and kept on disk.

* ``filled(...)``: colours and depth of a picture of a mesh
"""

from typing import Any

import numpy as np
from numba import njit


@njit(cache=True)
def filled(places: Any, depth: Any, uv: Any, level: Any, texels: Any, sizes: Any, shape: tuple[int, int]) -> Any:
    """Colours (h, w, 3) uint8, and (h, w) float32 one over the depth (1/m, 0 where nothing is), of what is nearest.

    ``places`` (T, 3, 2) pixels of the corners of triangles, of either side, ``depth`` (T, 3) metres, all before the
    camera; ``uv`` (T, 3, 2) in [0, 1], (0, 0) the lower left. A texture's copies lie one after another in ``texels``
    (N, 3) uint8, of which ``sizes`` (L, 3) tells where each begins, its height and width; ``level`` (T,) which of them
    a triangle is painted with. Beyond its rims it is repeated.
    """
    high, wide = shape
    image, near = np.zeros((high, wide, 3), np.uint8), np.zeros((high, wide), np.float32)
    for t in range(len(places)):
        (ax, ay), (bx, by), (cx, cy) = places[t]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        wa, wb, wc = 1.0 / depth[t, 0], 1.0 / depth[t, 1], 1.0 / depth[t, 2]
        start, rows, columns = sizes[level[t]]
        top, end = max(0, int(np.ceil(min(ay, by, cy)))), min(high - 1, int(np.floor(max(ay, by, cy))))
        left, right = max(0, int(np.ceil(min(ax, bx, cx)))), min(wide - 1, int(np.floor(max(ax, bx, cx))))
        for y in range(top, end + 1):
            for x in range(left, right + 1):
                a = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                b = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                c = 1.0 - a - b
                if a < 0.0 or b < 0.0 or c < 0.0:
                    continue
                w = a * wa + b * wb + c * wc
                if w <= near[y, x]:
                    continue
                near[y, x] = w
                a, b, c = a * wa / w, b * wb / w, c * wc / w
                u = a * uv[t, 0, 0] + b * uv[t, 1, 0] + c * uv[t, 2, 0]
                v = 1.0 - (a * uv[t, 0, 1] + b * uv[t, 1, 1] + c * uv[t, 2, 1])
                u, v = u - np.floor(u) if u < 0.0 or u > 1.0 else u, v - np.floor(v) if v < 0.0 or v > 1.0 else v
                column = min(max(u * columns - 0.5, 0.0), columns - 1.0)
                row = min(max(v * rows - 0.5, 0.0), rows - 1.0)
                i, j = min(int(column), max(columns - 2, 0)), min(int(row), max(rows - 2, 0))
                p, q = column - i, row - j
                one = start + j * columns + i
                right_of, below = min(columns - 1, 1), min(rows - 1, 1) * columns
                for k in range(3):
                    upper = texels[one, k] * (1.0 - p) + texels[one + right_of, k] * p
                    lower = texels[one + below, k] * (1.0 - p) + texels[one + below + right_of, k] * p
                    image[y, x, k] = int(upper * (1.0 - q) + lower * q + 0.5)
    return image, near
