"""Many ranges of one sorted array, taken at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Indices = NDArray[np.intp]


def taken(low: Indices, high: Indices) -> tuple[Indices, Indices]:
    """Rows and positions, row by row, of the half-open ranges ``low`` to ``high`` (Q, R)."""
    count = (high - low).ravel()
    ends = np.cumsum(count)
    at = np.arange(count.sum()) + np.repeat(low.ravel() - ends + count, count)
    return np.repeat(np.arange(len(low)), (high - low).sum(axis=1)), at
