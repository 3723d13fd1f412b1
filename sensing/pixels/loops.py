# ruff: noqa: ANN401 - what is compiled takes arrays of several types
"""The loops over lines and pixels of a photo's part, compiled (numba) and kept on disk.

``sensing.pixels.lines``, ``blocks`` and ``refine`` say what they are for.
"""

from typing import Any

import numpy as np

from sensing.compiled import compiled

NOWHERE = 99.0
"""Where there is no edge."""
ALONG = 0.8
"""Least share of the gradient that is along a line: within 36°."""


@compiled("Tuple((f8[:,::1], f8[:,::1], f8[::1], i8))(b1[:,::1], f4[:,::1], f8[:,::1], f8[:,::1], f8, i8)")
def rim_of(mask: Any, smooth: Any, depth: Any, near: Any, slack: float, rim: int) -> Any:
    """Places (N, 2) of a mask's (h, w) outline, its directions outward (N, 2) and depths (N,); of how many pixels.

    ``smooth`` (h, w): the mask, smoothed; ``near`` (h, w) m: what is nearer than the depth by more than ``slack`` hides
    it. None are within ``rim`` pixels of the part's own rim.
    """
    high, wide = mask.shape
    at, across, deep = np.empty((high * wide, 2)), np.empty((high * wide, 2)), np.empty(high * wide)
    n, whole = 0, 0
    for y in range(high):
        for x in range(wide):
            if not mask[y, x]:
                continue
            inside = x > 0 and y > 0 and x < wide - 1 and y < high - 1
            if inside and mask[y - 1, x] and mask[y + 1, x] and mask[y, x - 1] and mask[y, x + 1]:
                continue
            whole += 1
            if x < rim or y < rim or x >= wide - rim or y >= high - rim or near[y, x] <= depth[y, x] - slack:
                continue
            a = smooth[y - 1, x + 1] - smooth[y - 1, x - 1] + smooth[y + 1, x + 1] - smooth[y + 1, x - 1]
            b = smooth[y + 1, x - 1] - smooth[y - 1, x - 1] + smooth[y + 1, x + 1] - smooth[y - 1, x + 1]
            a = (a + 2.0 * (smooth[y, x + 1] - smooth[y, x - 1])) / 8.0
            b = (b + 2.0 * (smooth[y + 1, x] - smooth[y - 1, x])) / 8.0
            steep = np.hypot(a, b)
            if steep <= 0.02:
                continue
            off = min(max((smooth[y, x] - 0.5) / steep, -1.0), 1.0)
            across[n, 0], across[n, 1] = -a / steep, -b / steep
            at[n, 0], at[n, 1], deep[n] = x + off * across[n, 0], y + off * across[n, 1], depth[y, x]
            n += 1
    return at[:n].copy(), across[:n].copy(), deep[:n].copy(), whole


@compiled("f4[:,:,::1](f4[:,:,::1], f4[:,:,::1])")
def steepest_of(a: Any, b: Any) -> Any:
    """(h, w, 2) the slopes along x and y, (h, w, C) each, of the channel in which they are steepest."""
    high, wide, channels = a.shape
    result = np.empty((high, wide, 2), np.float32)
    for y in range(high):
        for x in range(wide):
            best, most = 0, np.float32(-1.0)
            for c in range(channels):
                steep = a[y, x, c] * a[y, x, c] + b[y, x, c] * b[y, x, c]
                if steep > most:
                    best, most = c, steep
            result[y, x, 0], result[y, x, 1] = a[y, x, best], b[y, x, best]
    return result


@compiled("Tuple((i8[:,::1], f8[:,::1]))(f4[:,:,::1], f4[:,:,::1], b1[:,::1], f8)")
def ridges_of(a: Any, b: Any, inside: Any, least: float) -> Any:
    """Places x, y (N, 2) ``inside`` (h, w) where a normal bends most, by more than ``least``, and which way (N, 2).

    ``a``, ``b`` (h, w, 3): its slopes along x and y.
    """
    high, wide = inside.shape
    bend, turn = np.empty((high, wide)), np.empty((high, wide))
    for y in range(high):
        for x in range(wide):
            xx, xy, yy = 0.0, 0.0, 0.0
            for c in range(3):
                xx += a[y, x, c] * a[y, x, c]
                xy += a[y, x, c] * b[y, x, c]
                yy += b[y, x, c] * b[y, x, c]
            bend[y, x], turn[y, x] = np.sqrt(xx + yy), 0.5 * np.arctan2(2.0 * xy, xx - yy)
    at, across, n = np.empty((high * wide, 2), np.int64), np.empty((high * wide, 2)), 0
    for y in range(high):
        for x in range(wide):
            if not inside[y, x] or bend[y, x] <= least:
                continue
            c, s = np.cos(turn[y, x]), np.sin(turn[y, x])
            i, j = int(np.rint(c)), int(np.rint(s))
            ahead = bend[min(max(y + j, 0), high - 1), min(max(x + i, 0), wide - 1)]
            behind = bend[min(max(y - j, 0), high - 1), min(max(x - i, 0), wide - 1)]
            if bend[y, x] >= ahead and bend[y, x] > behind:
                at[n, 0], at[n, 1], across[n, 0], across[n, 1] = x, y, c, s
                n += 1
    return at[:n].copy(), across[:n].copy()


@compiled("f8(f4[:,:,::1], f8, f8, f8, f8)")
def rise_at(gradient: Any, x: float, y: float, a: float, b: float) -> float:
    """How steep a photo is at a place along (a, b); 0 where it is not steepest about along it, and outside."""
    i, j = int(np.floor(x)), int(np.floor(y))
    if i < 0 or j < 0 or i >= gradient.shape[1] - 1 or j >= gradient.shape[0] - 1:
        return 0.0
    p, q = x - i, y - j
    u, v = 0.0, 0.0
    for dj in range(2):
        for di in range(2):
            share = (q if dj else 1.0 - q) * (p if di else 1.0 - p)
            u += share * gradient[j + dj, i + di, 0]
            v += share * gradient[j + dj, i + di, 1]
    along = abs(u * a + v * b)
    return along if along > ALONG * np.hypot(u, v) else 0.0


@compiled("b1(f8[::1], i8, f8)")
def is_peak(rise: Any, k: int, least: float) -> bool:
    """Whether it is an edge."""
    return bool(rise[k] > least and rise[k] >= rise[k - 1] and rise[k] >= rise[k + 1])


@compiled("f8[::1](f4[:,:,::1], f8[:,::1], f8[:,::1], i8, f8)")
def edge_off(gradient: Any, at: Any, across: Any, reach: int, least: float) -> Any:
    """(N,) pixels from places (N, 2) along unit vectors (N, 2) to the nearest edge across, steeper than ``least``."""
    result = np.full(len(at), NOWHERE)
    rise = np.empty(2 * reach + 3)
    for n in range(len(at)):
        for k in range(2 * reach + 3):
            a, b, step = across[n, 0], across[n, 1], k - reach - 1
            rise[k] = rise_at(gradient, at[n, 0] + step * a, at[n, 1] + step * b, a, b)
        for far in range(reach + 1):
            k = reach + 1 - far
            if not is_peak(rise, k, least):
                k = reach + 1 + far
                if not is_peak(rise, k, least):
                    continue
            bend = rise[k - 1] - 2.0 * rise[k] + rise[k + 1]
            result[n] = k - reach - 1
            if bend < -1e-6:
                result[n] += 0.5 * (rise[k - 1] - rise[k + 1]) / bend
            break
    return result


@compiled("Tuple((i8[:,::1], f8[:,::1], f8[:,::1]))(i8[:,::1], f8[:,::1], f8[:,::1], i8, i8)")
def both_sides(colour: Any, at: Any, across: Any, length: int, colours: int) -> Any:
    """Which colour (N, 2 · ``length`` + 1) of (h, w) is along each line; how often each (N, C) is inside, outside."""
    high, wide = colour.shape
    seen = np.empty((len(at), 2 * length + 1), np.int64)
    inside, outside = np.zeros((len(at), colours)), np.zeros((len(at), colours))
    for n in range(len(at)):
        for k in range(2 * length + 1):
            step = k - length
            x = min(max(int(np.rint(at[n, 0] + step * across[n, 0])), 0), wide - 1)
            y = min(max(int(np.rint(at[n, 1] + step * across[n, 1])), 0), high - 1)
            seen[n, k] = colour[y, x]
            if step < -1:
                inside[n, colour[y, x]] += 1.0
            elif step > 1:
                outside[n, colour[y, x]] += 1.0
    return seen, inside, outside


@compiled("f8[:,::1](f8[:,::1], f8, f8)")
def nearby(at: Any, own: float, wide: float) -> Any:
    """(N, N) how much each place tells of each other: a bell ``wide`` px, 0 within the square root of ``own``."""
    many = len(at)
    result = np.zeros((many, many))
    for i in range(many):
        for j in range(i):
            square = (at[i, 0] - at[j, 0]) ** 2 + (at[i, 1] - at[j, 1]) ** 2
            if square >= own:
                result[i, j] = result[j, i] = np.exp(-square / (2.0 * wide * wide))
    return result


@compiled("Tuple((f8[:,::1], f8[::1]))(i8[:,::1], f8[:,::1], f8[:,::1], f8[:,::1], f8)")
def shifted(seen: Any, inside: Any, outside: Any, inner: Any, every: float) -> Any:
    """Logarithms (N, S) of how likely lines' colours (N, K) are where the outline is shifted, and (N,) how far apart.

    ``inside``, ``outside`` (N, C): shares of colours; ``inner`` (S, K): how far each step is inside once shifted.
    """
    many, long = seen.shape
    result, apart = np.empty((many, len(inner))), np.zeros(many)
    share = np.empty(long)
    for n in range(many):
        for k in range(long):
            a, b = inside[n, seen[n, k]] + every, outside[n, seen[n, k]] + every
            share[k] = a / (a + b)
            if 2 * k != long - 1:
                apart[n] += np.log(2.0 * share[k]) if 2 * k < long - 1 else np.log(2.0 - 2.0 * share[k])
        for s in range(len(inner)):
            likely = 1.0
            for k in range(long):
                likely *= max(share[k] * (2.0 * inner[s, k] - 1.0) + 1.0 - inner[s, k], 1e-12)
            result[n, s] = np.log(likely)
    return result, apart


@compiled("void(f8, f8, f8, f8[:,::1], f8[::1], f8[:,::1])")
def motion(x: float, y: float, depth: float, K: Any, middle: Any, moves: Any) -> None:
    """Put into ``moves`` (2, 6) by how many pixels the surface at a pixel moves with each part of a step.

    A step turns about ``middle`` (3,) by a vector, radians, and then moves, m.
    """
    fx, fy = K[0, 0], K[1, 1]
    px, py = (x - K[0, 2]) / fx * depth, (y - K[1, 2]) / fy * depth
    a, b, c = px - middle[0], py - middle[1], depth - middle[2]
    ux, uz, vy, vz = fx / depth, -fx * px / depth**2, fy / depth, -fy * py / depth**2
    moves[0, 0], moves[0, 1], moves[0, 2] = b * uz, c * ux - a * uz, -b * ux
    moves[1, 0], moves[1, 1], moves[1, 2] = b * vz - c * vy, -a * vz, a * vy
    moves[0, 3], moves[0, 4], moves[0, 5] = ux, 0.0, uz
    moves[1, 3], moves[1, 4], moves[1, 5] = 0.0, vy, vz


@compiled("Tuple((f8[:,::1], f8[::1]))(f8[:,::1], f8[:,::1], f8[::1], f8[:,::1], f8[::1], f8[::1], f8[::1])")
def of_lines(at: Any, across: Any, depth: Any, K: Any, middle: Any, off: Any, weight: Any) -> Any:
    """Gauss-Newton's (6, 6) and (6,) of lines that ought to be ``off`` (N,) pixels farther along, by weights (N,)."""
    told, slope, moves, along = np.zeros((6, 6)), np.zeros(6), np.empty((2, 6)), np.empty(6)
    for n in range(len(at)):
        if weight[n] == 0.0:
            continue
        motion(at[n, 0], at[n, 1], depth[n], K, middle, moves)
        for i in range(6):
            along[i] = across[n, 0] * moves[0, i] + across[n, 1] * moves[1, i]
        for i in range(6):
            slope[i] += weight[n] * off[n] * along[i]
            for j in range(i + 1):
                told[i, j] += weight[n] * along[i] * along[j]
    return told + np.tril(told, -1).T, slope


@compiled("Tuple((i8[:,::1], i8[::1], f8[:,::1]))(b1[:,::1], f4[:,:,::1], f4[:,:,::1], i8)")
def squared(visible: Any, photo: Any, drawn: Any, side: int) -> Any:
    """Which square of ``side`` pixels each visible pixel is in, -1 for none; how many are in each; sums over each.

    Sums (S, 15): of photo and drawn (h, w, 3), of their squares and their product, three of each.
    """
    high, wide = visible.shape
    across = wide // side + 1
    which = np.full((high, wide), -1)
    count, sums = np.zeros((high // side + 1) * across, np.int64), np.zeros(((high // side + 1) * across, 15))
    for y in range(high):
        for x in range(wide):
            if visible[y, x]:
                n = y // side * across + x // side
                which[y, x] = n
                count[n] += 1
                for k in range(3):
                    p, q = np.float64(photo[y, x, k]), np.float64(drawn[y, x, k])
                    sums[n, k] += p
                    sums[n, 3 + k] += q
                    sums[n, 6 + k] += p * p
                    sums[n, 9 + k] += q * q
                    sums[n, 12 + k] += p * q
    return which, count, sums


@compiled(
    "f8[:,:,::1](i8[:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,:,:,::1], f8[:,::1], UniTuple(f8[:,::1], 2), f8[::1])",
)
def print_off(which: Any, photo: Any, drawn: Any, slopes: Any, depth: Any, scale: Any, middle: Any) -> Any:
    """(N, 3, 7): of pixels in squares, row by row, how the drawn changes with each part of a step, and what it is off.

    ``slopes`` (2, h, w, 3): of the drawn, along x and along y; ``scale``: K (3, 3), and gains (S, 3) of squares.
    """
    K, gains = scale
    result, moves, n = np.empty(((which >= 0).sum(), 3, 7)), np.empty((2, 6)), 0
    for y in range(which.shape[0]):
        for x in range(which.shape[1]):
            if which[y, x] >= 0:
                motion(x, y, depth[y, x], K, middle, moves)
                for k in range(3):
                    gain = gains[which[y, x], k]
                    a, b = gain * slopes[0, y, x, k], gain * slopes[1, y, x, k]
                    for i in range(6):
                        result[n, k, i] = a * moves[0, i] + b * moves[1, i]
                    result[n, k, 6] = gain * drawn[y, x, k] - photo[y, x, k]
                n += 1
    return result


@compiled("Tuple((f8[:,::1], f8[::1]))(i8[:,::1], f8[:,:,::1], i8[::1], f8[::1], f8)")
def of_print(which: Any, off: Any, count: Any, variance: Any, odd: float) -> Any:
    """Gauss-Newton's (6, 6) and (6,) of print that is ``off`` (N, 3, 7), as told by ``print_off``.

    Each square (S,) has an offset of its own; what is off by more than ``odd`` times the ``variance`` (3,) counts less.
    """
    squares = which.ravel()[which.ravel() >= 0]
    means = np.zeros((len(count), 3, 7))
    for n in range(len(off)):
        for k in range(3):
            for i in range(7):
                means[squares[n], k, i] += off[n, k, i] / count[squares[n]]
    told, slope, own = np.zeros((6, 6)), np.zeros(6), np.empty(7)
    for n in range(len(off)):
        for k in range(3):
            for i in range(7):
                own[i] = off[n, k, i] - means[squares[n], k, i]
            trust = 1.0 / (variance[k] * (1.0 + own[6] ** 2 / (variance[k] * odd)) ** 2)
            for i in range(6):
                slope[i] += trust * own[i] * own[6]
                for j in range(i + 1):
                    told[i, j] += trust * own[i] * own[j]
    return told + np.tril(told, -1).T, slope
