"""Data by where they lie and which way they face: angles on the screen, and a grid over the image and the circle.

Angles are radians, clockwise from +x. Many places are asked of the grid at once.

* ``Grid``: the data by cell
* ``taken(low, high)``: many ranges of one sorted array at once
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Indices


def wrapped(angle: Floats) -> Floats:
    """The same angles, radians, between −π and π."""
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def screen_angle(direction: Floats, at: Floats) -> Floats:
    """Angle on the screen, radians clockwise from +x, of a direction (…, 3) at a place (…, 3), camera frame."""
    du = direction[..., 0] * at[..., 2] - at[..., 0] * direction[..., 2]
    return np.asarray(np.arctan2(direction[..., 1] * at[..., 2] - at[..., 1] * direction[..., 2], du))


def part_of_circle(angle: Floats, parts: int) -> Indices:
    """In which of so many equal parts of the circle, from 0, each angle lies."""
    return np.asarray(np.floor(np.mod(angle, 2.0 * np.pi) / (2.0 * np.pi) * parts).astype(np.intp) % parts)


def taken(low: Indices, high: Indices) -> tuple[Indices, Indices]:
    """Rows and positions, row by row, of the half-open ranges ``low`` to ``high`` (Q, R)."""
    count = (high - low).ravel()
    at = np.arange(count.sum()) + np.repeat(low.ravel() - np.cumsum(count) + count, count)
    return np.repeat(np.arange(len(low)), (high - low).sum(axis=1)), at


CELL, HALF = 16, 0.5
"""Pixels of a cell; and the first pixel's half that is left of, or above, its centre."""
TURNS = 18
"""Parts of the circle: what is within one of them faces alike."""


@dataclass(frozen=True, eq=False)
class Grid:
    """``datum`` (N,) data by cell; ``starts`` where each cell begins among them.

    ``shape`` parts of the circle, cells down and across.
    """

    datum: Indices
    starts: Indices
    shape: tuple[int, int, int]

    def near(self, uv: Floats, reach: Floats | float, angle: Floats | None = None) -> tuple[Indices, Indices]:
        """Places and data of all pairs at most ``reach`` pixels apart, and of some farther, place by place.

        Uv (Q, 2) pixels, in or about the image.

        ``reach``: one, or (Q,) each place's own. ``angle`` (Q,) radians: only what faces within a part of the circle,
        and some farther.
        """
        turns, down, across = self.shape
        reach, cells = np.broadcast_to(np.asarray(reach, float), len(uv))[:, None], np.array([across, down])
        low = np.clip(np.floor((uv + HALF - reach) / CELL), 0, cells).astype(np.intp)
        high = np.clip(np.floor((uv + HALF + reach) / CELL), -1, cells - 1).astype(np.intp)
        rows = low[:, 1, None] + np.arange(int((high[:, 1] - low[:, 1]).max(initial=-1)) + 1)
        inside = (rows <= high[:, 1, None]) & (high[:, 0, None] >= 0) & (low[:, 0, None] < across)
        place, row = np.nonzero(inside)
        row = rows[place, row]
        left, right = np.clip(low[place, 0], 0, across - 1), np.clip(high[place, 0], 0, across - 1)
        parts = np.arange(turns)[None] if angle is None else _beside(angle)[place]
        first = (parts * down + row[:, None]) * across
        which, at = taken(self.starts[first + left[:, None]], self.starts[first + right[:, None] + 1])
        return place[which], self.datum[at]

    def facing(self, angle: Floats) -> tuple[Indices, Indices]:
        """Numbers and data of all pairs within a part of the circle, and of some farther: angle (Q,) radians."""
        cells = self.shape[1] * self.shape[2]
        parts = _beside(angle)
        number, at = taken(self.starts[parts * cells], self.starts[(parts + 1) * cells])
        return number, self.datum[at]


def _beside(angle: Floats) -> Indices:
    """(Q, 3) the part of the circle of each of Q angles, and those beside it."""
    return np.asarray((part_of_circle(angle, TURNS)[:, None] + np.array([-1, 0, 1])) % TURNS)


def grid_of(datum: Indices, uv: Floats, size: tuple[int, int], angle: Floats | None = None) -> Grid:
    """Of data ``datum`` (N,) at uv (N, 2) pixels in an image of ``size`` (width, height).

    ``angle`` (N,) radians: and by where they face.
    """
    shape = 1 if angle is None else TURNS, size[1] // CELL + 1, size[0] // CELL + 1
    column, row = np.floor((uv + HALF) / CELL).astype(np.intp).T
    part = np.zeros(len(uv), np.intp) if angle is None else part_of_circle(angle, TURNS)
    key = (part * shape[1] + np.clip(row, 0, shape[1] - 1)) * shape[2] + np.clip(column, 0, shape[2] - 1)
    order = np.argsort(key, kind="stable")
    return Grid(datum[order], np.searchsorted(key[order], np.arange(shape[0] * shape[1] * shape[2] + 1)), shape)
