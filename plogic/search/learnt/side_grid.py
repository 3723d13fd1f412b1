"""Sides of edges by where they lie and which way they face: a grid over the image and the circle, so that a hundred places are asked at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

CELL, TURNS = 32, 18
"""Pixels of a cell, and parts of the circle: what is within one of each is found."""


@dataclass(frozen=True, eq=False)
class SideGrid:
    """``datum`` (N,) sides of edges by cell; ``starts`` where each cell begins among them; ``shape`` cells down and across, one more all around."""

    datum: Indices
    starts: Indices
    shape: tuple[int, int]

    def near(self, uv: Floats, angle: Floats) -> tuple[Indices, Indices]:
        """Places and sides of all pairs within a cell and a part of the circle, and of some farther: uv (Q, 2) pixels, angle (Q,) radians."""
        down, across = self.shape
        column, row = _cells(uv, self.shape)
        part = _part(angle)
        turn, step = (shift.ravel()[None] for shift in np.meshgrid((-1, 0, 1), (-1, 0, 1), indexing="ij"))
        first = (((part[:, None] + turn) % TURNS) * down + row[:, None] + step) * across + column[:, None] - 1
        return self._taken(self.starts[first], self.starts[first + 3])

    def facing(self, angle: Floats) -> tuple[Indices, Indices]:
        """Numbers and sides of all pairs, anywhere in the image, that are within a part of the circle, and of some farther: angle (Q,) radians."""
        cells = self.shape[0] * self.shape[1]
        part = (_part(angle)[:, None] + np.array([-1, 0, 1])) % TURNS
        return self._taken(self.starts[part * cells], self.starts[(part + 1) * cells])

    def _taken(self, low: Indices, high: Indices) -> tuple[Indices, Indices]:
        """Numbers and sides of ranges (Q, R) of ``datum``."""
        count = (high - low).ravel()
        number = np.repeat(np.repeat(np.arange(len(low)), low.shape[1]), count)
        return number, self.datum[np.arange(count.sum()) + np.repeat(low.ravel() - np.cumsum(count) + count, count)]


def _part(angle: Floats) -> Indices:
    return np.asarray(np.floor(np.mod(angle, 2.0 * np.pi) / (2.0 * np.pi) * TURNS).astype(np.intp) % TURNS)


def _cells(uv: Floats, shape: tuple[int, int]) -> tuple[Indices, Indices]:
    column, row = (np.floor(uv / CELL).astype(np.intp) + 1).T
    return np.clip(column, 1, shape[1] - 2), np.clip(row, 1, shape[0] - 2)


def side_grid(datum: Indices, uv: Floats, angle: Floats, size: tuple[int, int]) -> SideGrid:
    """Of sides ``datum`` (N,) at uv (N, 2) pixels, facing angle (N,) radians, in an image of ``size`` (width, height)."""
    shape = -(-size[1] // CELL) + 2, -(-size[0] // CELL) + 2
    column, row = _cells(uv, shape)
    key = (_part(angle) * shape[0] + row) * shape[1] + column
    order = np.argsort(key, kind="stable")
    return SideGrid(datum[order], np.searchsorted(key[order], np.arange(TURNS * shape[0] * shape[1] + 3)), shape)
