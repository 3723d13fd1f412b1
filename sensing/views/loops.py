# ruff: noqa: ANN401 - what is compiled takes arrays of several types
"""The loops over pixels, places and templates, compiled (numba) when they are first called, and kept on disk.

Maps are int8, in steps; those of a type are stacked as ``sensing.views.maps`` says.
"""

from typing import Any

import numpy as np

from sensing.compiled import compiled

BINS = 12
"""Directions of edges in half a turn."""
STEPS = 32
"""Grades of a response."""
MOST = 100
"""Steps that a map says at most: a sum of all features is less than 2¹⁵."""
WEAK, FAINT = 0.03, 1.9
"""A weight below this is none; widths beyond which a response is less than a grade."""


@compiled()
def responses(weight: Any, angle: Any, bins: int, period: float, width: float) -> Any:
    """(bins, h, w) uint8: how strong an edge is at each pixel in each of some directions evenly in a period."""
    high, wide = weight.shape
    result = np.zeros((bins, high, wide), np.uint8)
    reach = min((bins - 1) // 2, int(np.ceil(FAINT * width * bins / period)))
    for y in range(high):
        for x in range(wide):
            if weight[y, x] >= WEAK:
                at = angle[y, x] * bins / period
                nearest = int(np.rint(at))
                for k in range(nearest - reach, nearest + reach + 1):
                    off = (at - k) * period / bins / width
                    result[k % bins, y, x] = int(weight[y, x] * np.exp(-(off**2)) * (STEPS - 0.01))
    return result


@compiled()
def counted(grade: Any, kind: Any, kinds: int) -> Any:
    """(kinds, ``STEPS``): how often each grade is met in pixels of each kind."""
    result = np.zeros((kinds, STEPS))
    for k in range(grade.shape[0]):
        for y in range(grade.shape[1]):
            for x in range(grade.shape[2]):
                result[kind[y, x], grade[k, y, x]] += 1.0
    return result


@compiled()
def told(grade: Any, kind: Any, table: Any) -> Any:
    """(bins, h, w) int8: what a table (kinds, ``STEPS``) says of the grades of pixels of each kind."""
    result = np.empty(grade.shape, np.int8)
    for k in range(grade.shape[0]):
        for y in range(grade.shape[1]):
            for x in range(grade.shape[2]):
                result[k, y, x] = table[kind[y, x], grade[k, y, x]]
    return result


@compiled()
def stacked(border: Any, edges: Any, inside: Any, outside: Any, weights: Any) -> Any:
    """The maps of a type one upon the other, int8.

    ``border`` (2 · ``BINS``, h, w) and ``edges`` (``BINS``, h, w) as ``weights`` (3,) say for both on an outline and
    for edges within; ``inside``, ``outside`` (k, h, w). At most ``MOST``.
    """
    both, bins, colours = len(border), len(edges), len(inside)
    result = np.empty((both + bins + 2 * colours, *border.shape[1:]), np.int8)
    for k in range(both):
        for y in range(border.shape[1]):
            for x in range(border.shape[2]):
                value = np.rint(weights[0] * border[k, y, x] + weights[1] * edges[k % bins, y, x])
                result[k, y, x] = int(min(max(value, -MOST), MOST))
    for k in range(bins):
        for y in range(border.shape[1]):
            for x in range(border.shape[2]):
                result[both + k, y, x] = int(np.rint(weights[2] * edges[k, y, x]))
    result[both + bins : both + bins + colours] = inside
    result[both + bins + colours :] = outside
    return result


@compiled()
def channel(kind: int, angle: float, colour: int, colours: int) -> int:
    """Which map of a stack says what there is of a feature."""
    if kind == 0:
        return int(np.rint(angle / (np.pi / BINS))) % (2 * BINS)
    if kind == 1:
        return 2 * BINS + int(np.rint(angle / (np.pi / BINS))) % BINS
    return 3 * BINS + (kind - 2) * colours + colour


@compiled()
def offsets(views: Any, some: Any, turns: int, size: float, wide: int, cells: int) -> Any:
    """Where in a flat stack each feature is of some views (S,), turned, of a size in cells, from its middle's cell.

    (S · turns, F), sorted, and (S · turns,) how many there are. A map has so many ``cells``, ``wide`` in a row.
    """
    features = views.kind.shape[1]
    result = np.zeros((len(some) * turns, features), np.int64)
    count = np.zeros(len(some) * turns, np.int64)
    for i in range(len(some) * turns):
        v, a, n = some[i // turns], 2.0 * np.pi * (i % turns) / turns, 0
        c, s = np.cos(a) * size, np.sin(a) * size
        for f in range(features):
            if views.kind[v, f] >= 0:
                x = int(np.rint(c * views.at[v, f, 0] - s * views.at[v, f, 1]))
                y = int(np.rint(s * views.at[v, f, 0] + c * views.at[v, f, 1]))
                m = channel(views.kind[v, f], views.angle[v, f] + a, views.colour[v, f], len(views.palette))
                result[i, n] = m * cells + y * wide + x
                n += 1
        result[i, :n].sort()
        count[i] = n
    return result, count


@compiled()
def scanned(stack: Any, offset: Any, count: Any, start: int, end: int, block: int) -> Any:
    """The best sum of each of T templates in each of B blocks of cells from ``start`` to ``end``; and its cell.

    (T, B) int16 and (T, B).
    """
    blocks = (end - start + block - 1) // block
    best, where = np.zeros((len(offset), blocks), np.int16), np.zeros((len(offset), blocks), np.int32)
    total = np.zeros(block, np.int16)
    for b in range(blocks):
        here = start + b * block
        n = min(block, end - here)
        for t in range(len(offset)):
            total[:] = 0
            for f in range(count[t]):
                row = stack[offset[t, f] + here : offset[t, f] + here + n]
                for j in range(n):
                    total[j] += row[j]
            most = total[0]
            for j in range(1, n):
                most = max(most, total[j])
            k = 0
            while total[k] != most:
                k += 1
            best[t, b] = most
            where[t, b] = here + k
    return best, where


@compiled()
def score(stack: Any, views: Any, row: Any, scale: float, power: float) -> float:
    """The sum of a view's features at a row's place: view, turn, size, and place in pixels of the photo."""
    v, a, size = int(row[0]), row[1], row[2] * scale
    x0, y0 = (row[3] + 0.5) * scale - 0.5, (row[4] + 0.5) * scale - 0.5
    c, s, total = np.cos(a) * size, np.sin(a) * size, 0
    high, wide = stack.shape[1], stack.shape[2]
    for f in range(views.kind.shape[1]):
        if views.kind[v, f] >= 0:
            x = int(np.rint(x0 + c * views.at[v, f, 0] - s * views.at[v, f, 1]))
            y = int(np.rint(y0 + s * views.at[v, f, 0] + c * views.at[v, f, 1]))
            if 0 <= x < wide and 0 <= y < high:
                m = channel(views.kind[v, f], views.angle[v, f] + a, views.colour[v, f], len(views.palette))
                total += stack[m, y, x]
    return total * (row[2] / 100.0) ** power


@compiled()
def laid_in(stack: Any, views: Any, cells: Any, which: Any, turned: Any, size: Any) -> Any:
    """The best sum of views in each of some squares of cells, and its cell: (B, T) int32, and (B, T, 2), x and y.

    A square's ``cells`` (B, 4) are those from x0, y0 to before x1, y1; in it T views are laid down, ``which`` (B, T),
    ``turned`` (B, T), of one ``size`` (B,) in cells. Nothing of a view is outside the stack.
    """
    squares, turns = which.shape
    best, where = np.full((squares, turns), -(2**30), np.int32), np.zeros((squares, turns, 2), np.int32)
    for b in range(squares):
        x0, y0, wide, high = cells[b, 0], cells[b, 1], cells[b, 2] - cells[b, 0], cells[b, 3] - cells[b, 1]
        total = np.zeros((high, wide), np.int16)
        for t in range(turns):
            v = which[b, t]
            c, s = np.cos(turned[b, t]) * size[b], np.sin(turned[b, t]) * size[b]
            total[:] = 0
            for f in range(views.kind.shape[1]):
                if views.kind[v, f] >= 0:
                    x = x0 + int(np.rint(c * views.at[v, f, 0] - s * views.at[v, f, 1]))
                    y = y0 + int(np.rint(s * views.at[v, f, 0] + c * views.at[v, f, 1]))
                    angle = views.angle[v, f] + turned[b, t]
                    m = channel(views.kind[v, f], angle, views.colour[v, f], len(views.palette))
                    for i in range(high):
                        row = stack[m, y + i, x : x + wide]
                        for j in range(wide):
                            total[i, j] += row[j]
            for i in range(high):
                for j in range(wide):
                    if total[i, j] > best[b, t]:
                        best[b, t] = total[i, j]
                        where[b, t, 0], where[b, t, 1] = x0 + j, y0 + i
    return best, where


@compiled()
def in_view(turn: float, here: Any, there: Any) -> float:
    """The turn with which a view ``there`` (3, 3) is nearest to one ``here`` of a turn."""
    rest = here @ there.T
    c, s = np.cos(turn), np.sin(turn)
    return float(
        np.arctan2(
            s * rest[0, 0] + c * rest[1, 0] - c * rest[0, 1] + s * rest[1, 1],
            c * rest[0, 0] - s * rest[1, 0] + s * rest[0, 1] + c * rest[1, 1],
        )
    )


@compiled()
def beside(stack: Any, views: Any, row: Any, scale: float, power: float) -> Any:
    """The row in the first view next to its own in which it fits better, or itself."""
    for w in views.beside[int(row[0])]:
        other = row.copy()
        other[0] = w
        other[1] = in_view(row[1], views.turn[int(row[0])], views.turn[w])
        other[5] = score(stack, views, other, scale, power)
        if other[5] > row[5]:
            return other
    return row


@compiled()
def climbed(stack: Any, views: Any, seeds: Any, scale: float, steps: Any, rounds: int, power: float) -> Any:
    """Rows (N, 6) of a view, its turn, a size, a place and a score, moved to where they fit best near.

    ``steps`` (3,): of the turn, of the size's share, and of the place in sizes; they are halved where nothing is
    better, at most so many ``rounds``.
    """
    result = seeds.copy()
    for n in range(len(seeds)):
        row, by = seeds[n].copy(), steps.copy()
        row[5] = score(stack, views, row, scale, power)
        for _ in range(rounds):
            before = row[5]
            row = beside(stack, views, row, scale, power)
            for k in range(8):
                other, sign = row.copy(), 1.0 if k % 2 else -1.0
                if k < 2:
                    other[1] += sign * by[0]
                elif k < 4:
                    other[2] *= 1.0 + sign * by[1]
                else:
                    other[1 + k // 2] += sign * by[2] * row[2]
                other[5] = score(stack, views, other, scale, power)
                if other[5] > row[5]:
                    row = other
            if row[5] == before:
                by *= 0.5
                if by[0] < 0.2 * steps[0]:
                    break
        result[n] = row
    return result


@compiled()
def apart(rows: Any, turns: Any, most: int, angle: float, share: float, near: float) -> Any:
    """Which of rows (N, 3) of size, x, y and turns (N, 3, 3), best first, are like none before; ``most`` of them."""
    kept = np.zeros(most, np.int64)
    n, trace = 0, 1.0 + 2.0 * np.cos(angle)
    for j in range(len(rows)):
        if n == most:
            break
        new = True
        for i in range(n):
            k = kept[i]
            if (
                abs(rows[k, 1] - rows[j, 1]) < near * rows[j, 0]
                and abs(rows[k, 2] - rows[j, 2]) < near * rows[j, 0]
                and abs(np.log(rows[k, 0] / rows[j, 0])) < share
                and (turns[k] * turns[j]).sum() > trace
            ):
                new = False
                break
        if new:
            kept[n] = j
            n += 1
    return kept[:n]
