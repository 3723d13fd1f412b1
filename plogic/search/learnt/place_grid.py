"""Keypoints by where they lie: a grid over the image, so that many places are asked at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

CELL, HALF = 16, 0.5
"""Pixels of a cell; and the first pixel's half that is left of, or above, its centre."""


@dataclass(frozen=True, eq=False)
class PlaceGrid:
    """``datum`` (N,) data by cell; ``starts`` where each cell begins among them; ``shape`` cells down and across."""

    datum: Indices
    starts: Indices
    shape: tuple[int, int]

    def near(self, uv: Floats, reach: float) -> tuple[Indices, Indices]:
        """Places and data of all pairs at most ``reach`` pixels apart, and of some farther: uv (Q, 2) pixels, in or about the image."""
        down, across = self.shape
        rows = np.arange(-(-2 * reach // CELL) + 1, dtype=np.intp)  # as many as a span of twice the reach can meet
        top = np.floor((uv[:, 1] + HALF - reach) / CELL).astype(np.intp)[:, None] + rows
        left, right = (np.floor((uv[:, 0] + HALF + side) / CELL).astype(np.intp)[:, None] for side in (-reach, reach))
        inside = (top >= 0) & (top < down) & (right >= 0) & (left < across)
        row = np.clip(top, 0, down - 1) * across
        low = self.starts[row + np.clip(left, 0, across - 1)]
        high = np.where(inside, self.starts[row + np.clip(right, 0, across - 1) + 1], low)
        count = (high - low).ravel()
        place = np.repeat(np.repeat(np.arange(len(uv)), len(rows)), count)
        return place, self.datum[np.arange(count.sum()) + np.repeat(low.ravel() - np.cumsum(count) + count, count)]


def place_grid(datum: Indices, uv: Floats, size: tuple[int, int]) -> PlaceGrid:
    """Of data ``datum`` (N,) at uv (N, 2) pixels in an image of ``size`` (width, height)."""
    shape = -(-size[1] // CELL), -(-size[0] // CELL)
    column, row = np.floor((uv + HALF) / CELL).astype(np.intp).T
    key = np.clip(row, 0, shape[0] - 1) * shape[1] + np.clip(column, 0, shape[1] - 1)
    order = np.argsort(key, kind="stable")
    return PlaceGrid(datum[order], np.searchsorted(key[order], np.arange(shape[0] * shape[1] + 1)), shape)
