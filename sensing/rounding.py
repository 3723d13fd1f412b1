"""Rounding of many numbers at once, to the same decimals as Python's ``round`` of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DOUBTFUL = 1e-6
"""Nearer than this to the middle between two neighbours, in units of the last decimal, a product's own rounding could
decide."""
_LARGEST = 2.0**31
"""Up to here, in those units, a product is exact to less than that."""


def rounded(values: NDArray[np.float64], digits: int) -> NDArray[np.float64]:
    """Each of ``values`` (...) as ``round(value, digits)``, for digits from 0 to 15; NaN and infinities stay."""
    unit = 10.0**digits
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = values * unit
        result = np.asarray(np.rint(scaled) / unit)
        sure = (np.abs(scaled) < _LARGEST) & (np.abs(scaled - np.floor(scaled) - 0.5) > _DOUBTFUL)
    doubtful = ~sure & np.isfinite(values)
    result[doubtful] = [round(value, digits) for value in values[doubtful].tolist()]
    return np.where(np.isfinite(values), result, values)
