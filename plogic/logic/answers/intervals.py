"""Anytime bounds: intervals that contain P(query | evidence) whenever one asks, and shrink while alternatives are decided best first.

A partial decision with what is certain under it says of its mass: the query and the evidence hold, the query fails
under the evidence, the evidence fails, or all is open. From the masses that are certain, and those that are possible,
follows the interval; rounding widens it.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from plogic.logic.answers.three_valued import columns, truth_of
from plogic.logic.grounding.ground_program import TRUE

if TYPE_CHECKING:
    from plogic.logic.answers.three_valued import Bools
    from plogic.logic.grounding.ground_program import Ground

AT_ONCE = 64
"""Partial decisions that are taken further together."""
MOST_OPEN = 200_000
"""Partial decisions that may be open: more would not fit into memory, so the bounds stay as they are."""
ROUNDING = 2.0**-52
"""What one addition of masses can be wrong by, at most."""


@dataclass(order=True)
class _Open:
    """A partial decision whose mass is not settled. Of each query, with the evidence: whether it certainly, and possibly, holds or fails."""

    minus_mass: float
    order: int
    decided: tuple[int, ...] = field(compare=False)
    certain: Bools = field(compare=False)
    possible: Bools = field(compare=False)


class Bounds:
    """``intervals`` at any time; ``refine`` takes the most probable open decisions further, until ``done``.

    ``certain``, ``possible``: masses of (query holds and evidence, query fails and evidence), ``(2, queries)``;
    ``sums``: additions so far.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self.truth = truth_of(ground)
        self.queries = [literal for _, literal in ground.asked]
        self.outcomes = [[*alternative.shares, alternative.rest] for alternative in ground.alternatives]
        self.certain = np.zeros((2, len(self.queries)))
        self.possible = np.zeros((2, len(self.queries)))
        self.sums = 0
        self.open: list[_Open] = []
        self._add([((), 1.0)])

    @property
    def done(self) -> bool:
        """Nothing is open, or there is no room for more."""
        return not self.open or len(self.open) > MOST_OPEN

    def refine(self) -> None:
        """Decide one more alternative in each of the most probable open decisions."""
        children: list[tuple[tuple[int, ...], float]] = []
        for _ in range(min(AT_ONCE, len(self.open))):
            item = heapq.heappop(self.open)
            self._count(item.minus_mass, item.certain, item.possible)
            shares = self.outcomes[len(item.decided)]
            children += [((*item.decided, i), -item.minus_mass * share) for i, share in enumerate(shares) if share > 0]
        self._add(children)

    def intervals(self) -> list[tuple[float, float]]:
        """Of each query, an interval that contains its probability given the evidence; [0, 1] where the evidence may be impossible."""
        slack = (self.sums + 1) * ROUNDING
        least, most = np.maximum(self.certain - slack, 0.0), np.minimum(self.possible + slack, 1.0)
        with np.errstate(invalid="ignore"):
            low = np.where(least[0] > 0, least[0] / (least[0] + most[1]) - ROUNDING, 0.0)
            high = np.where(least[1] > 0, most[0] / (most[0] + least[1]) + ROUNDING, 1.0)
        return [(max(float(a), 0.0), min(float(b), 1.0)) for a, b in zip(low, high, strict=True)]

    def _add(self, decisions: list[tuple[tuple[int, ...], float]]) -> None:
        """Count the decisions; those that leave something open are kept, those that the evidence excludes are not counted."""
        certain = self.truth.certain(columns((decided for decided, _ in decisions), len(self.outcomes)))
        holds, fails = self._evidence(certain)
        yes, no = self._queries(certain)
        for column, (decided, mass) in enumerate(decisions):
            if fails[column]:
                continue
            settled = np.stack((yes[:, column], no[:, column])) & holds[column]
            possible = ~np.stack((no[:, column], yes[:, column]))
            self._count(mass, settled, possible)
            if len(decided) < len(self.outcomes) and not (settled == possible).all():
                heapq.heappush(self.open, _Open(-mass, self.sums, decided, settled, possible))

    def _count(self, mass: float, certain: Bools, possible: Bools) -> None:
        self.certain += mass * certain
        self.possible += mass * possible
        self.sums += 1

    def _evidence(self, certain: Bools) -> tuple[Bools, Bools]:
        observed = np.array(self.ground.observed, dtype=np.int64)
        return np.asarray(certain[observed].all(axis=0)), np.asarray(certain[-observed].any(axis=0))

    def _queries(self, certain: Bools) -> tuple[Bools, Bools]:
        """Whether each certainly holds, or fails, ``(queries, columns)``."""
        never = np.zeros(certain.shape[1], dtype=bool)
        sides = [
            (never, ~never) if q is None else (~never, never) if q == TRUE else (certain[q], certain[-q])
            for q in self.queries
        ]
        both = np.array(sides, dtype=bool).reshape(len(sides), 2, certain.shape[1])
        return both[:, 0], both[:, 1]
