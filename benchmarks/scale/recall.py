"""How many types an index can hold.

Where the right vote stands among those of other types, and where it would stand among more.

* ``Standing``: in one trial, how much weight the box of the right vote has, and how much those of the others have

The votes of a type depend on no other type. So those of T types are T times as many as those of one, and where the
right one stands follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

RESAMPLES = 2000
"""Of the trials, for an interval."""
INTERVAL = 2.5, 97.5
"""Percentiles between which a resampled mean lies in 95 of 100."""


@dataclass(frozen=True, eq=False)
class Standing:
    """``right``: the greatest weight of a right vote, 0 where there is none; ``alike``: right votes of this weight.

    ``above``, ``level``: wrong votes of the same type with more, with as much. ``others`` (H,): votes of ``types``
    other types, by their weight.
    """

    right: int
    alike: int
    above: int
    level: int
    others: NDArray[np.int64]
    types: int

    def before(self, types: int) -> tuple[float, float]:
        """The expected number of votes that weigh more than the right one, and of those that weigh as much.

        Of so many types in all.
        """
        share = (types - 1) / self.types if self.types else 0.0
        level = float(self.others[self.right : self.right + 1].sum())
        return self.above + share * float(self.others[self.right + 1 :].sum()), self.level + share * level

    def chance(self, types: int, laid: int) -> float:
        """How likely one right vote is among the first ``laid`` where those of one weight come in any order.

        0 where nothing votes right.
        """
        if not self.right:
            return 0.0
        above, level = self.before(types)
        room = min(1.0, max(0.0, (laid - above) / (level + self.alike)))
        return float(1.0 - (1.0 - room) ** self.alike)

    def joined(self, others: NDArray[np.int64], types: int) -> Standing:
        """With the votes of more types, by their weight."""
        longest = max(len(self.others), len(others))
        total = np.pad(self.others, (0, longest - len(self.others))) + np.pad(others, (0, longest - len(others)))
        return Standing(self.right, self.alike, self.above, self.level, total, self.types + types)


def recall(standings: Sequence[Standing], types: int, laid: int) -> float:
    """The mean chance over trials."""
    return float(np.mean([standing.chance(types, laid) for standing in standings]))


def interval(values: Sequence[float], rng: np.random.Generator) -> tuple[float, float]:
    """Between which the mean lies in 95 of 100 resamples of the trials."""
    array = np.asarray(values, float)
    means = array[rng.integers(len(array), size=(RESAMPLES, len(array)))].mean(axis=1)
    low, high = np.percentile(means, INTERVAL)
    return float(low), float(high)


def line(x: Sequence[float], y: Sequence[float]) -> tuple[float, float]:
    """The a and b of y = a + b x, least squares."""
    b, a = np.polyfit(np.asarray(x, float), np.asarray(y, float), 1)
    return float(a), float(b)
