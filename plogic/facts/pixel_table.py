"""What the photo's pixels say of a hypothesis, by which of its occluders are present (formalism §9.10).

A pixel counts once, for its front-most present claimant: what stands behind is told with that masked. A *context* is
the set of those present that change what is seen.

* ``PixelTable(("h2",), (8.3, 1.2))``: 8.3 in log-odds where h2 is absent, 1.2 where it is present
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from plogic.facts.fact_rows import PixelKeys, PixelRow

MOST_BEFORE = 6
"""Occluders of a hypothesis that a table tells (§9.10)."""


class PixelTable(NamedTuple):
    """``occluders``: who changes what is seen, most pixels first, at most six; ``left_out``: who else does.

    ``odds`` (2^n,): in entry r those are present whose bit is set in r, bit i being the i-th of ``occluders``.
    """

    occluders: tuple[str, ...]
    odds: tuple[float, ...]
    left_out: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Everybody who changes what is seen."""
        return (*self.occluders, *self.left_out)

    def rows(self) -> Iterator[tuple[tuple[str, ...], float]]:
        """Each context with its log-odds, the smallest first."""
        n = range(len(self.occluders))
        for r in sorted(range(len(self.odds)), key=lambda r: (r.bit_count(), r)):
            yield tuple(self.occluders[i] for i in n if r >> i & 1), self.odds[r]

    def told(self, present: Mapping[str, NDArray[np.bool_]]) -> NDArray[np.float64]:
        """(M,) log-odds in M worlds: ``present["h2"]`` (M,) says in which h2 is there."""
        row = np.zeros(len(next(iter(present.values()))), np.intp)
        for i, name in enumerate(self.occluders):
            row |= present[name].astype(np.intp) << i
        return np.array(self.odds)[row]

    def among(self, kept: Collection[str]) -> PixelTable:
        """What it says where nobody else is present."""
        mine = [i for i, name in enumerate(self.occluders) if name in kept]
        rows = [sum(1 << i for bit, i in enumerate(mine) if r >> bit & 1) for r in range(2 ** len(mine))]
        left_out = tuple(name for name in self.left_out if name in kept)
        return PixelTable(tuple(self.occluders[i] for i in mine), tuple(self.odds[r] for r in rows), left_out)

    def document(self) -> PixelKeys:
        """The keys of the interpretation."""
        keys: PixelKeys = {"pixels_beside": [{"present": list(some), "pixels": odds} for some, odds in self.rows()]}
        if self.left_out:
            keys["pixels_left_out"] = list(self.left_out)
        return keys


def table_of(rows: Sequence[PixelRow], left_out: Sequence[str] = ()) -> PixelTable:
    """The table of rows of a document; NaN where they are not every set of at most six once."""
    occluders = tuple(dict.fromkeys(name for row in rows for name in row["present"]))
    bit = {name: 1 << i for i, name in enumerate(occluders)}
    odds = [float("nan")] * (2 ** len(occluders) if len(occluders) <= MOST_BEFORE else 0)
    for row in rows if odds else ():
        odds[sum(bit[name] for name in dict.fromkeys(row["present"]))] = float(row["pixels"]) + 0.0  # no -0.0
    if len(rows) != len(odds):
        odds = [float("nan")]
    return PixelTable(occluders, tuple(odds), tuple(left_out))
