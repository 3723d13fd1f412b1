"""P(ev) in mode `to_B`, linear in the features: one look at each feature, then a sum for every set of others that are present (§5.5, §8).

The second form of ``plogic.scene.readings.score_reading.acceptance`` in this mode, tested equal to it. Vocabulary:

* ``Linear(["h2", "h5"], 0.7, [(1, 0.1, True), (3, 0.2, False)])``: of the shares of dv, 0.7 is concordant whoever is
  present; 0.1 where h2 (bit 0 of 1) is absent, since an appearance was found for it; and 0.2 where h2 or h5 is present,
  since none was
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.bounds import alternative
from plogic.facts.dependence import ordered
from plogic.facts.expected import expected
from plogic.scene.factors.weight_tables import LONGEST_LIST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.facts.hypothesis import Hypothesis
    from plogic.scene.factors.alternatives import Cast

    Cell = tuple[int, float, bool]


class Linear(NamedTuple):
    """``names``: who changes a cell, most cells first; ``fixed``: None where nothing is detected or ev is undefined; ``cells`` that change."""

    names: list[str]
    fixed: float | None
    cells: list[Cell]

    def chances(self, epsilon: float) -> list[float] | NDArray[np.float64]:
        """P(present(h) | which of ``names`` are present), a bit table (2^n,); of length 1 where it is impossible."""
        if self.fixed is None:
            return [0.0]
        size = 1 << len(self.names)
        if size > LONGEST_LIST:
            return _array(size, self.fixed, self.cells, epsilon)
        changing = [0.0] * size
        for mask, share, found in self.cells:
            changing = [x if (row & mask != 0) is found else x + share for row, x in enumerate(changing)]
        fixed, spread = self.fixed, 1.0 - 2.0 * epsilon
        return [epsilon + spread * _snapped(x + fixed) for x in changing]


def linear(cast: Cast, h: Hypothesis) -> Linear:
    """One look at the features of a hypothesis."""
    opaque, unhiding, solid = cast.opaque, cast.unhiding[h.id], h.opaque
    weights: list[float] = []
    same: list[int] = []
    changing: list[tuple[int, set[str], bool]] = []
    cells: dict[str, int] = {}
    detected = False
    for f in h.features:
        if not f.in_image:
            continue
        found = f.match is not None
        detected = detected or found
        awaited = expected(f, solid)
        hiders = {g for g in f.hidden_by if g in opaque and g not in unhiding} if awaited and f.hidden_by else None
        if hiders:
            for g in hiders:
                cells[g] = cells.get(g, 0) + 1
            changing.append((len(weights), hiders, found))
        elif awaited == found:
            same.append(len(weights))
        weights.append(f.dv)
    names = ordered(cells)
    shares = alternative(weights) if detected else []
    if not shares:
        return Linear(names, None, [])
    bit = {name: 1 << i for i, name in enumerate(names)}
    fixed = sum([shares[i] for i in same], 0.0)
    return Linear(names, fixed, [(sum([bit[g] for g in hiders]), shares[i], found) for i, hiders, found in changing])


def _snapped(total: float) -> float:
    """A sum of shares that is 0 or 1 but for rounding is 0 or 1: the certain stays certain."""
    return 1.0 if total > 1.0 - 1e-12 else 0.0 if total < 1e-12 else total


def _array(size: int, fixed: float, cells: Sequence[Cell], epsilon: float) -> NDArray[np.float64]:
    rows, changing = np.arange(size), np.zeros(size)
    for mask, share, found in cells:
        changing += share * (((rows & mask) > 0) != found)
    total = changing + fixed
    total = np.where(total > 1.0 - 1e-12, 1.0, np.where(total < 1e-12, 0.0, total))
    return epsilon + (1.0 - 2.0 * epsilon) * total
