# ruff: noqa: ANN401 - what is compiled takes arrays of several types
"""What a painted mesh shows in each pixel, compiled (numba) and kept on disk.

``Facets``, of T triangles: corners (T, 3, 3) m, normals (T, 3), duals (T, 2, 3), normals at the corners (T, 3, 3),
texture coordinates (T, 3, 2), texels a metre (T,). ``Pyramid``: a texture's copies one after the other (N, 3) uint8,
and where each starts, how wide and how high it is (L,). ``View``: K, camera_from_object's turn (3, 3), and the camera's
place (3,) m, object frame. ``Picture``: colour, depth and normal, as ``sensing.pixels.drawn.Drawn`` has them.
"""

from typing import Any

import numpy as np

from sensing.compiled import compiled
from sensing.simulated.raycast import STEEPEST

FACETS = "Tuple((f8[:,:,::1], f8[:,::1], f8[:,:,::1], f8[:,:,::1], f8[:,:,::1], f8[::1]))"
PYRAMID = "Tuple((u1[:,::1], i8[::1], i8[::1], i8[::1]))"
VIEW = "Tuple((f8[:,::1], f8[:,::1], f8[::1]))"
PICTURE = "Tuple((f4[:,:,::1], f8[:,::1], f4[:,:,::1]))"
GRAZING = 1e-9
"""Sine of the angle to a facet below which its first corner stands for where it is met."""

ON_EDGE = 1e-9
"""Share of a triangle by which a pixel may be beyond its edge: none is lost between two."""


@compiled(f"f4[:,::1](i8[::1], i8[::1], {VIEW})")
def sights(low: Any, high: Any, view: Any) -> Any:
    """(N, 3) unit vectors, object frame, through the pixels from ``low`` to ``high``, row by row."""
    K, turn, _ = view
    wide = high[0] - low[0]
    result = np.empty(((high[1] - low[1]) * wide, 3), np.float32)
    for n in range(len(result)):
        x = (low[0] + n % wide - K[0, 2]) / K[0, 0]
        y = (low[1] + n // wide - K[1, 2]) / K[1, 1]
        length = np.sqrt(x * x + y * y + 1.0)
        for k in range(3):
            result[n, k] = (x * turn[0, k] + y * turn[1, k] + turn[2, k]) / length
    return result


@compiled(f"i4[::1](i8[::1], i8[::1], {VIEW}, f8[:,::1], i8[:,::1])")
def nearest_facets(low: Any, high: Any, view: Any, corners: Any, triangles: Any) -> Any:
    """(N,) which of triangles (T, 3) of corners (V, 3) each pixel from ``low`` to ``high`` shows, -1 for none.

    All corners must be before the camera. Each triangle is laid over the pixels in its box: of few triangles faster
    than rays.
    """
    K, turn, eye = view
    seen, wide = np.empty((len(corners), 3)), high[0] - low[0]
    for n in range(len(corners)):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            off = corners[n, k] - eye[k]
            x, y, z = x + turn[0, k] * off, y + turn[1, k] * off, z + turn[2, k] * off
        seen[n, 0], seen[n, 1], seen[n, 2] = x / z * K[0, 0] + K[0, 2], y / z * K[1, 1] + K[1, 2], 1.0 / z
    result, nearness = np.full((high[1] - low[1]) * wide, -1, np.int32), np.zeros((high[1] - low[1]) * wide)
    for t in range(len(triangles)):
        a, b, c = seen[triangles[t, 0]], seen[triangles[t, 1]], seen[triangles[t, 2]]
        left, right = max(low[0], int(np.ceil(min(a[0], b[0], c[0])))), min(high[0] - 1, int(max(a[0], b[0], c[0])))
        upper, lower = max(low[1], int(np.ceil(min(a[1], b[1], c[1])))), min(high[1] - 1, int(max(a[1], b[1], c[1])))
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        for y in range(upper, lower + 1):
            for x in range(left, right + 1):
                p = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
                q = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
                near = p * a[2] + q * b[2] + (1.0 - p - q) * c[2]
                n = (y - low[1]) * wide + x - low[0]
                if min(p, q, 1.0 - p - q) >= -ON_EDGE and near > nearness[n]:
                    nearness[n], result[n] = near, t
    return result


@compiled("UniTuple(f8, 3)(f8[:,::1], f8, f8, f8)")
def mixed(corners: Any, a: float, b: float, c: float) -> Any:
    """(3,) of corners (3, 3), each by its weight."""
    return (
        a * corners[0, 0] + b * corners[1, 0] + c * corners[2, 0],
        a * corners[0, 1] + b * corners[1, 1] + c * corners[2, 1],
        a * corners[0, 2] + b * corners[1, 2] + c * corners[2, 2],
    )


@compiled("i8(i8, i8)")
def within(k: int, many: int) -> int:
    """A texel's number, mirrored at the rims."""
    k %= 2 * many
    return k if k < many else 2 * many - 1 - k


@compiled(f"void({PYRAMID}, f8, f8, f8, f4[::1])")
def look_up(pyramid: Any, u: float, v: float, footprint: float, colour: Any) -> None:
    """Put into ``colour`` (3,) what is at (u, v), (0, 0) the lower left, in the copy for so many texels a pixel."""
    texels, start, wide, high = pyramid
    level = min(max(int(np.rint(np.log2(max(footprint, 1e-9)))), 0), len(start) - 1)
    width, height = wide[level], high[level]
    x, y = u * width - 0.5, (1.0 - v) * height - 0.5
    i, j = int(np.floor(x)), int(np.floor(y))
    a, b = x - i, y - j
    left, right = within(i, width), within(i + 1, width)
    above, below = start[level] + within(j, height) * width, start[level] + within(j + 1, height) * width
    for k in range(3):
        upper = texels[above + left, k] * (1.0 - a) + texels[above + right, k] * a
        lower = texels[below + left, k] * (1.0 - a) + texels[below + right, k] * a
        colour[k] = upper * (1.0 - b) + lower * b


@compiled("f8(f8[::1], f8[::1], f8[::1])")
def sum_of(along: Any, place: Any, eye: Any) -> float:
    """How far a place (3,) is from the camera's along a direction (3,), m."""
    return float(along[0] * (place[0] - eye[0]) + along[1] * (place[1] - eye[1]) + along[2] * (place[2] - eye[2]))


@compiled(f"void(i4[::1], i8[::1], i8, {VIEW}, {FACETS}, {PYRAMID}, {PICTURE})")
def paint(triangles: Any, low: Any, wide: int, view: Any, facets: Any, pyramid: Any, picture: Any) -> None:
    """Fill a picture from pixel ``low`` on, rows of ``wide``, with what the triangles met there show, -1 for none."""
    K, turn, eye = view
    corners, normals, duals, rounded, uv, texels = facets
    colours, depths, facing = picture
    for n in range(len(triangles)):
        t = triangles[n]
        if t < 0:
            continue
        i, j = low[0] + n % wide, low[1] + n // wide
        x, y = (i - K[0, 2]) / K[0, 0], (j - K[1, 2]) / K[1, 1]
        sink, rise, steep = 0.0, 0.0, 0.0
        for k in range(3):
            along = x * turn[0, k] + y * turn[1, k] + turn[2, k]
            sink += normals[t, k] * along
            rise += normals[t, k] * (corners[t, 0, k] - eye[k])
            steep += normals[t, k] ** 2
        length = np.sqrt(x * x + y * y + 1.0)
        met = abs(sink) > GRAZING * np.sqrt(steep) * length
        depth = rise / sink if met else sum_of(turn[2], corners[t, 0], eye)
        b, c = 0.0, 0.0
        for k in range(3):
            off = eye[k] + depth * (x * turn[0, k] + y * turn[1, k] + turn[2, k]) - corners[t, 0, k]
            b += duals[t, 0, k] * off
            c += duals[t, 1, k] * off
        a, b, c = min(max(1.0 - b - c, 0.0), 1.0), min(max(b, 0.0), 1.0), min(max(c, 0.0), 1.0)
        p, q, r = mixed(rounded[t], a, b, c)
        size = max(np.sqrt(p * p + q * q + r * r), 1e-12)
        seen = 0.0
        for k in range(3):
            value = (turn[k, 0] * p + turn[k, 1] * q + turn[k, 2] * r) / size
            facing[j, i, k] = value
            seen += value * (x if k == 0 else y if k == 1 else 1.0)
        depths[j, i] = depth
        footprint = texels[t] * depth / K[0, 0] / np.sqrt(max(abs(seen) / length, STEEPEST))
        u = a * uv[t, 0, 0] + b * uv[t, 1, 0] + c * uv[t, 2, 0]
        v = a * uv[t, 0, 1] + b * uv[t, 1, 1] + c * uv[t, 2, 1]
        look_up(pyramid, u, v, footprint, colours[j, i])
