"""Arrays as text for a page: base64 of little-endian numbers, which the script reads as typed arrays."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

LARGEST = 3e38
"""Of a number in single precision; beyond it stands this."""


def floats(values: ArrayLike) -> str:
    """In single precision, row by row."""
    return _text(np.clip(np.asarray(values, dtype=np.float64), -LARGEST, LARGEST).astype("<f4"))


def shorts(values: ArrayLike) -> str:
    """Whole numbers from 0 to 65535."""
    numbers = np.asarray(values, dtype=np.int64)
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < 2**16:
        raise ValueError(f"must be from 0 to 65535, not {numbers.min()} to {numbers.max()}")
    return _text(numbers.astype("<u2"))


def _text(array: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> str:
    return base64.b64encode(array.tobytes()).decode()
