"""A factor graph under construction: log weights accumulated by scope.

Vocabulary: a *literal* ``(3, (1, 2))``, variable 3 is in one of these states; a *bit table* over n literals, an array (2^n,) whose row r
is for the joint truth values of which the i-th is bit i of r.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from plogic.inference.gates import observed, with_formulas
from plogic.inference.graph import Factor, FactorGraph

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.factors.alternatives import Literal
    from plogic.inference.gates import Formula

    Table = NDArray[np.float64]

WIDEST = 16
"""Bits of one factor: what spans more joint states is written with auxiliary variables."""
IMPOSSIBLE = -math.inf


def log(weight: float) -> float:
    """The natural logarithm; −inf of 0 (and of what rounding left below it)."""
    return math.log(weight) if weight > 0.0 else IMPOSSIBLE


class Tables:
    """``unary[v][s]`` and ``joint[scope]`` add up what is said of a variable, and of a scope of several; ``required`` formulas hold."""

    def __init__(self, cards: Sequence[int]) -> None:
        self.cards = list(cards)
        self.unary = [[0.0] * card for card in cards]
        self.joint: dict[tuple[int, ...], Table] = {}
        self.required: list[Formula] = []

    def add(self, scope: tuple[int, ...], table: Table) -> None:
        """One more factor, ``scope`` strictly increasing, one axis a variable."""
        if len(scope) == 1:
            self.unary[scope[0]] = [x + float(y) for x, y in zip(self.unary[scope[0]], table, strict=True)]
            return
        known = self.joint.get(scope)
        self.joint[scope] = table if known is None else known + table

    def shape(self, scope: Sequence[int]) -> tuple[int, ...]:
        """The states of each variable."""
        return tuple([self.cards[v] for v in scope])

    def too_wide(self, variables: Sequence[int]) -> bool:
        """Whether a factor over the variables would span more than 2^WIDEST joint states, or more axes than are handy."""
        return len(variables) > WIDEST or math.prod(self.shape(variables)) > 1 << WIDEST

    def variable(self, log_weights: Sequence[float]) -> int:
        """An auxiliary variable with its unary log weights; its number."""
        self.cards.append(len(log_weights))
        self.unary.append(list(log_weights))
        return len(self.cards) - 1

    def add_bits(self, literals: Sequence[Literal], logs: Table) -> None:
        """A factor given as a bit table of log weights over literals, of which several may speak of one variable."""
        scope = tuple(sorted({v for v, _ in literals}))
        if self.too_wide(scope):
            literals = [(self.indicator([literal]), (1,)) if self.cards[literal[0]] > 2 else literal for literal in literals]
        self._add_rows(literals, logs)

    def _add_rows(self, literals: Sequence[Literal], logs: Table) -> None:
        scope = tuple(sorted({v for v, _ in literals}))
        self.add(scope, logs[self._rows(scope, literals)])

    def _rows(self, scope: tuple[int, ...], literals: Sequence[Literal]) -> NDArray[np.int64]:
        """The row of the bit table for every joint state of the scope."""
        bits = {v: [0] * self.cards[v] for v in scope}
        for i, (v, states) in enumerate(literals):
            for s in states:
                bits[v][s] |= 1 << i
        rows = np.array(bits[scope[0]], np.int64)
        for v in scope[1:]:
            rows = np.add.outer(rows, np.array(bits[v], np.int64))
        return rows

    def indicator(self, literals: Sequence[Literal]) -> int:
        """A binary variable that is 1 where one of the literals holds: a chain of deterministic factors of three variables each."""
        last: int | None = None
        for literal in literals:
            new = self.variable((0.0, 0.0))
            inputs = [literal] if last is None else [literal, (last, (1,))]
            rows = np.arange(2 ** (len(inputs) + 1))
            holds = (rows & (1 << len(inputs)) - 1) > 0
            self._add_rows([*inputs, (new, (1,))], np.where(holds == (rows >> len(inputs) > 0), 0.0, IMPOSSIBLE))
            last = new
        if last is None:
            return self.variable((0.0, IMPOSSIBLE))
        return last

    def graph(self) -> FactorGraph:
        """What was added, unary factors first (those that say something), then the others by scope."""
        unary = [Factor((v,), np.array(logs)) for v, logs in enumerate(self.unary) if any(logs)]
        plain = FactorGraph(tuple(self.cards), (*unary, *(Factor(scope, self.joint[scope]) for scope in sorted(self.joint))))
        return observed(*with_formulas(plain, self.required)) if self.required else plain
