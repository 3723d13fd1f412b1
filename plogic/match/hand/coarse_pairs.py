"""Pairs: the smallest sets of appearances that, inside one view cell, fix a whole pose (§6.3).

Two features on two appearances give the roll and the scale; the cell gives the direction. Everything is done on arrays
of thousands at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

ARM_TOLERANCE = np.radians(16.0)
"""How far an arm may lie from the edge that the nearest cell predicts: half a cell's width plus the detector's
error."""
MOST_PAIRS = 60_000
"""Pairs that are kept of one type."""


@dataclass(frozen=True)
class Pairs:
    """N coarse poses: cell, first and second feature and appearance, (N,) each; ``roll`` radians; ``scale`` pixels per metre."""

    cell: NDArray[np.intp]
    feature: NDArray[np.intp]
    datum: NDArray[np.intp]
    other_feature: NDArray[np.intp]
    other_datum: NDArray[np.intp]
    roll: NDArray[np.float64]
    scale: NDArray[np.float64]

    def take(self, index: NDArray[np.intp]) -> Pairs:
        """The pairs at ``index``."""
        return Pairs(*(getattr(self, name)[index] for name in self.__dataclass_fields__))
