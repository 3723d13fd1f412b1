"""Γ by what its data look like: the data of each appearance type one after the other.

* ``TypedData``: for each appearance type its data
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class TypedData:
    """``looks`` (A,) number of each datum's type, −1 for one that no sight has.

    Of the D data that some sight looks like and that have an angle: ``places`` (D, 2) ideal pixels, ``angles`` (D,)
    radians, type by type; those of type n are ``count`` (L + 1,) from ``first`` (L + 1,) on; the last type has none:
    that of what is padded, −1.
    """

    looks: Indices
    places: Floats
    angles: Floats
    first: Indices
    count: Indices

    def of(self, looks: NDArray[np.integer[Any]]) -> tuple[Indices, Indices]:
        """All data of types ``looks`` (S,): (N,) whose it is, and (N,) its place in the table."""
        count = self.count[looks]
        row = np.repeat(np.arange(len(looks)), count)
        return row, np.arange(len(row)) + np.repeat(self.first[looks] - (np.cumsum(count) - count), count)


def typed_data(data: Data, names: Sequence[str]) -> TypedData:
    """The data that have an angle; ``names`` of the appearance types, by number."""
    number = {name: i for i, name in enumerate(names)}
    looks = np.array([number.get(name, -1) for name in data.types], np.intp)
    some = np.flatnonzero((looks >= 0) & np.isfinite(data.angle))
    some = some[np.lexsort((data.angle[some], *data.ideal[some].T, looks[some]))]  # ties must not follow the order of Γ
    count = np.bincount(looks[some], minlength=len(names) + 1)
    return TypedData(looks, data.ideal[some], data.angle[some], np.cumsum(count) - count, count)
