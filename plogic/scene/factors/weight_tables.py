"""A factor graph under construction: log weights accumulated by scope.

Vocabulary: a *literal* ``(3, (1, 2))``, variable 3 is in one of these states; a *bit table* over n literals, an array
(2^n,) whose row r is for the joint truth values of which the i-th is bit i of r.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from plogic.inference.gates import Formula, observed, with_formulas
from plogic.inference.graph import Factor, FactorGraph

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from geometry.arrays import Floats
    from plogic.scene.factors.alternatives import Literal


Table: TypeAlias = "Floats"
"""One axis a variable."""

WIDEST = 16
"""Bits of one factor: what spans more joint states is written with auxiliary variables."""
LONGEST_LIST = 64
"""Joint states up to which plain lists are quicker than arrays."""
IMPOSSIBLE = -math.inf


def log(weight: float) -> float:
    """The natural logarithm; −inf of 0 (and of what rounding left below it)."""
    return math.log(weight) if weight > 0.0 else IMPOSSIBLE


def logs_of(weights: Iterable[float]) -> list[float]:
    """``log`` of each."""
    ln = math.log
    return [ln(weight) if weight > 0.0 else IMPOSSIBLE for weight in weights]


def too_wide(cards: Sequence[int]) -> bool:
    """Whether a factor over variables with so many states would span more than 2^WIDEST joint states, or more axes than are handy."""
    return len(cards) > WIDEST or math.prod(cards) > 1 << WIDEST


class Tables:
    """``unary[v][s]``, ``lists[scope]`` and ``arrays[scope]`` add up what is said of a variable, and of a scope of several.

    Scopes of up to ``LONGEST_LIST`` joint states have lists, in C order; the others arrays. ``required`` formulas hold.
    """

    def __init__(self, cards: Sequence[int]) -> None:
        self.cards = list(cards)
        self.unary = [[0.0] * card for card in cards]
        self.lists: dict[tuple[int, ...], list[float]] = {}
        self.arrays: dict[tuple[int, ...], Table] = {}
        self.required: list[Formula] = []

    def add(self, scope: tuple[int, ...], table: Table) -> None:
        """One more factor, ``scope`` strictly increasing, one axis a variable."""
        if table.size <= LONGEST_LIST or len(scope) == 1:
            self.add_list(scope, table.ravel().tolist())
        else:
            known = self.arrays.get(scope)
            self.arrays[scope] = table if known is None else known + table

    def add_list(self, scope: tuple[int, ...], logs: list[float]) -> None:
        """As ``add``, in C order; ``logs`` becomes ours."""
        if len(scope) == 1:
            self.unary[scope[0]] = [x + y for x, y in zip(self.unary[scope[0]], logs, strict=True)]
        elif len(logs) > LONGEST_LIST:
            self.add(scope, np.array(logs).reshape(self.shape(scope)))
        else:
            known = self.lists.get(scope)
            self.lists[scope] = logs if known is None else [x + y for x, y in zip(known, logs, strict=True)]

    def forbid(self, pairs: Iterable[tuple[tuple[int, int], tuple[int, int]]]) -> None:
        """The two (variable, state) of a pair never hold together."""
        rows: dict[tuple[int, int], list[int]] = {}
        for one, other in pairs:
            (v, s), (w, t) = (one, other) if one <= other else (other, one)
            if v != w:
                rows.setdefault((v, w), []).append(s * self.cards[w] + t)
            elif s == t:
                self.unary[v][s] = IMPOSSIBLE
        for scope, mine in rows.items():
            logs = [0.0] * math.prod(self.shape(scope))
            for row in mine:
                logs[row] = IMPOSSIBLE
            self.add_list(scope, logs)

    def shape(self, scope: Sequence[int]) -> tuple[int, ...]:
        """The states of each variable."""
        cards = self.cards
        return tuple([cards[v] for v in scope])

    def variable(self, log_weights: Sequence[float]) -> int:
        """An auxiliary variable with its unary log weights; its number."""
        self.cards.append(len(log_weights))
        self.unary.append(list(log_weights))
        return len(self.cards) - 1

    def add_bits(self, literals: Sequence[Literal], logs: Sequence[float] | Table) -> None:
        """A factor given as a bit table of log weights over literals, of which several may speak of one variable."""
        if too_wide([self.cards[v] for v in {v for v, _ in literals}]):
            literals = [
                (self.indicator([literal]), (1,)) if self.cards[literal[0]] > 2 else literal for literal in literals
            ]
        self._add_rows(literals, logs)

    def _add_rows(self, literals: Sequence[Literal], logs: Sequence[float] | Table) -> None:
        bits: dict[int, list[int]] = {}
        for i, (v, states) in enumerate(literals):
            mine = bits.setdefault(v, [0] * self.cards[v])
            for s in states:
                mine[s] |= 1 << i
        scope = tuple(sorted(bits))
        if math.prod(self.shape(scope)) > LONGEST_LIST:
            self.add(scope, np.asarray(logs)[functools.reduce(np.add.outer, [np.array(bits[v]) for v in scope])])
            return
        rows = bits[scope[0]]
        for v in scope[1:]:
            mine = bits[v]
            rows = [row + bit for row in rows for bit in mine]
        self.add_list(scope, [float(logs[row]) for row in rows])

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
        factors = [Factor((v,), np.array(logs)) for v, logs in enumerate(self.unary) if any(logs)]
        for scope in sorted(self.lists.keys() | self.arrays.keys()):
            logs = self.lists.get(scope)
            factors.append(
                Factor(scope, self.arrays[scope] if logs is None else np.array(logs).reshape(self.shape(scope)))
            )
        plain = FactorGraph(tuple(self.cards), tuple(factors))
        return observed(*with_formulas(plain, self.required)) if self.required else plain
