"""Γ by what its data look like: the nearest datum of the right type, near the right angle, of any number of places at once.

* ``TypedData``: for each appearance type its data, as a padded table
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.angles import wrapped

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.search.data import Data

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]


BLOCK = 2_000_000
"""Sights and data that are compared at a time."""


@dataclass(frozen=True, eq=False)
class TypedData:
    """``looks`` (A,) number of each datum's type, −1 for one that no sight has; ``rows`` (L + 1, K) data of each type, −1 where there are no more.

    ``places`` (L + 1, K, 2) ideal pixels, far outside the image where there is none; ``angles`` (L + 1, K) radians; ``count`` (L + 1,).
    """

    looks: Indices
    rows: Indices
    places: Floats
    angles: Floats
    count: Indices

    def nearest(self, uv: Floats, looks: Indices, angle: Floats, tolerance: Floats, turned: float) -> tuple[Indices, Floats, Floats]:
        """Datum (N, V), −1 for none, how far it is, pixels, and turned, radians: of N poses with V sights at uv (N, V, 2) that face angle (N, V).

        Within ``tolerance`` (N,) pixels and ``turned`` radians. A datum serves the nearest of a pose's sights that want it.
        """
        slot, off, bent = np.zeros(looks.shape, np.intp), np.zeros(looks.shape), np.zeros(looks.shape)
        wide = max(1, BLOCK // max(1, looks.shape[1] * self.rows.shape[1]))
        for start in range(0, len(looks), wide):
            some = slice(start, start + wide)
            slot[some], off[some], bent[some] = self._nearest(uv[some], looks[some], angle[some], turned)
        datum = np.where(off <= tolerance[:, None], self.rows[looks, slot], -1)
        pose, sight = np.nonzero(datum >= 0)
        order = np.lexsort((off[pose, sight], datum[pose, sight], pose))
        pose, sight = pose[order], sight[order]
        again = np.zeros(len(pose), bool)
        again[1:] = (pose[1:] == pose[:-1]) & (datum[pose[1:], sight[1:]] == datum[pose[:-1], sight[:-1]])
        datum[pose[again], sight[again]] = -1
        return datum, off, bent

    def _nearest(self, uv: Floats, looks: Indices, angle: Floats, turned: float) -> tuple[Indices, Floats, Floats]:
        apart = self.places[looks] - uv[:, :, None]
        square = (apart * apart).sum(axis=3)
        bent = wrapped(self.angles[looks] - angle[:, :, None])
        square[np.abs(bent) > turned] = np.inf
        slot = square.argmin(axis=2)
        best = *np.indices(slot.shape, sparse=True), slot
        return slot, np.sqrt(square[best]), bent[best]


def typed_data(data: Data, names: Sequence[str]) -> TypedData:
    """The data that have an angle; ``names`` of the appearance types, by number."""
    number = {name: i for i, name in enumerate(names)}
    looks = np.array([number.get(name, -1) for name in data.types], np.intp)
    some = np.flatnonzero((looks >= 0) & np.isfinite(data.angle))
    some = some[np.lexsort((data.angle[some], *data.ideal[some].T, looks[some]))]  # ties must not follow the order of Γ
    count = np.bincount(looks[some], minlength=len(names) + 1)
    slot = np.arange(len(some)) - np.searchsorted(looks[some], looks[some])
    shape = len(names) + 1, max(1, int(count.max(initial=0)))
    rows, places, angles = np.full(shape, -1, np.intp), np.full((*shape, 2), 1e6), np.zeros(shape)
    rows[looks[some], slot], places[looks[some], slot], angles[looks[some], slot] = some, data.ideal[some], data.angle[some]
    return TypedData(looks, rows, places, angles, count)
