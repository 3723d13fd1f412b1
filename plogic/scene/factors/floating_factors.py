"""The soft constraint of support (Σc): a world weighs q, the chance that something unknown holds it, for each hypothesis that floats in it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from plogic.base.bounds import bounded
from plogic.facts.gravity import GROUND

if TYPE_CHECKING:
    from plogic.facts.gravity import Foot, Gravity
    from plogic.scene.factors.alternatives import Cast, Literal
    from plogic.scene.factors.weight_tables import Tables

MOST_HOLDERS = 6
"""Variables of holders that one factor looks at; of more, one auxiliary variable says whether any holds."""


def add_floating(tables: Tables, cast: Cast) -> frozenset[int]:
    """One factor a hypothesis that may float. The auxiliary variables that this took, each decided by the world."""
    gravity, first = cast.situation.gravity, len(tables.cards)
    if gravity is None or bounded(gravity.unknown_support) == 1.0:
        return frozenset()
    below = None if gravity.ground is not None else _Below(tables, cast, gravity)
    for foot in gravity.feet:
        holders = gravity.holders(foot.id)
        if below is None and GROUND in holders:
            continue
        lower = None if below is None else below.literal(foot)
        if below is None or lower is not None:
            _add(tables, cast, foot.id, holders, lower)
    return frozenset(range(first, len(tables.cards)))


def _add(tables: Tables, cast: Cast, name: str, holders: list[str], lower: Literal | None) -> None:
    """Q where it is present, none of ``holders`` is, and ``lower`` holds, if there is such a condition."""
    variable, state = cast.place[name]
    holding = cast.literals(holders)
    if len(holding) > MOST_HOLDERS:
        holding = [(tables.indicator(holding), (1,))]
    literals = [(variable, (state,)), *([] if lower is None else [lower]), *holding]
    logs = [0.0] * 2 ** len(literals)
    logs[1 if lower is None else 3] = math.log(bounded(_support(cast)))
    tables.add_bits(literals, logs)


def _support(cast: Cast) -> float:
    gravity = cast.situation.gravity
    return 1.0 if gravity is None else gravity.unknown_support


class _Below:
    """A chain over the feet by height: whether something present is surely lower than a foot. Each step adds one."""

    def __init__(self, tables: Tables, cast: Cast, gravity: Gravity) -> None:
        self.tables, self.cast = tables, cast
        self.feet = sorted(gravity.feet, key=lambda foot: foot.high)
        self.steps: list[Literal] = []

    def literal(self, foot: Foot) -> Literal | None:
        """None where nothing is lower in any world."""
        count = sum(other.high < foot.low for other in self.feet)
        while len(self.steps) < count:
            self.steps.append(self._next(self.feet[len(self.steps)]))
        return self.steps[count - 1] if count else None

    def _next(self, foot: Foot) -> Literal:
        variable, state = self.cast.place[foot.id]
        if not self.steps:
            return variable, (state,)
        last, states = self.steps[-1]
        if last == variable:
            return last, tuple(sorted((*states, state)))
        new = self.tables.variable((0.0, 0.0))
        logs = [0.0 if (row & 3 > 0) == (row > 3) else -math.inf for row in range(8)]
        self.tables.add_bits([self.steps[-1], (variable, (state,)), (new, (1,))], logs)
        return new, (1,)
