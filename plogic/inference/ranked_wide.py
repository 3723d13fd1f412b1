"""The ranking of a connected piece too wide for exact tables: A* under mini-bucket bounds.

A bucket whose table would be too large is split into *minis* of few enough cells, each of which takes its own minimum
over the bucket's variable: the sum of minima is no more than the minimum of the sum, so what is left is a bound that
never overestimates
    a cost (R. Dechter
and I. Rish, Mini-buckets, 2003), and A* under it finds all solutions in exact order, after opening more nodes than
needed. The bounds are
tightened by levelling the minis of a bucket: each gets the mean of their least costs per state (A. Ihler et al.,
Join-graph based cost-shifting schemes, 2012), which leaves their sum as it is.
"""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.errors import LimitError
from plogic.inference.graph import Part, aligned, in_groups
from plogic.inference.merge import Stream, nothing
from plogic.inference.ranked_tables import costs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.base.clock import Clock
    from plogic.inference.order import Order
    from plogic.inference.ranked_tables import Costs, Digits, Table

    Term = tuple[tuple[int, ...], Table]  # variables of the piece, one axis each

MOST_OPEN_NODES = 1_000_000  # nodes that wait at a time, about 300 bytes each
MINIS_BITS = 26.0  # bits: all minis together have about so many cells at most, of 8 bytes
BITS = (18.0, 16.0, 14.0, 12.0, 10.0)  # of one mini: the first that keeps to MINIS_BITS


class Mini:
    """A table over variables that come later in the order and, on the last axis, the bucket's.

    And its least costs over that.
    """

    def __init__(self, scope: tuple[int, ...], table: Table, impossible: int) -> None:
        self.scope = scope
        self.table = table
        least = np.asarray(table.min(axis=-1), dtype=table.dtype)
        self.least = np.where(least < impossible, least, impossible)

    def reader(self, cards: Sequence[int], shifts: Sequence[int]) -> tuple[Table, Table, list[tuple[int, int, int]]]:
        """(table of shape (rows, states), least costs (rows,), how each variable's state is cut from a code: shift, mask, stride)."""
        rows, cuts, stride = self.least.reshape(-1), [], 1
        for u in reversed(self.scope[:-1]):
            cuts.append((shifts[u], (1 << (cards[u] - 1).bit_length()) - 1, stride))
            stride *= cards[u]
        return self.table.reshape(len(rows), -1), rows, cuts


def wide(part: Part, order: Order, digits: Digits, clock: Clock) -> tuple[float, Stream]:
    """(log weight of cost 0, the solutions of one piece); OutOfTimeError past the clock."""
    scaled = costs([table for _, table in part.tables])
    return (0.0, nothing()) if scaled is None else (scaled.top, Wide(part, scaled, order, digits, clock))


class Wide(Stream):
    """Solutions of one piece: every step expands one node, a joint state of the last variables of the order."""

    def __init__(self, part: Part, scaled: Costs, order: Order, digits: Digits, clock: Clock) -> None:
        super().__init__()
        self._sequence = order.sequence[::-1]
        self._places, self._shift, self._width = digits.places, digits.shift + scaled.shift, order.width
        self._impossible = scaled.impossible
        shifts = [place.bit_length() - 1 for place in digits.places]
        bound, buckets = _bounds(part, scaled, order, clock)
        self._readers = [[mini.reader(part.cards, shifts) for mini in buckets[v]] for v in self._sequence]
        self._cards = [part.cards[v] for v in self._sequence]
        self._heap = [(bound, 0, 0)] if bound < scaled.impossible else []  # (bound, −depth, code)

    def advance(self) -> None:
        """Take the open node of the least bound, the deepest first: a solution if it is complete."""
        if not self._heap:
            self.done = True
            return
        bound, depth, code = heapq.heappop(self._heap)
        if -depth == len(self._sequence):
            self.found.append((bound << self._shift) + code)
            return
        steps = self._steps(-depth, code)
        place = self._places[self._sequence[-depth]]
        for state, step in enumerate(steps):
            if step is not None:
                heapq.heappush(self._heap, (bound + step, depth - 1, code + state * place))
        if len(self._heap) > MOST_OPEN_NODES:
            raise LimitError(
                f"ranking {len(self._sequence)} variables that hang together in tables of {self._width:.1f} bits leaves more than {MOST_OPEN_NODES} "
                f"partial states open: the limit",
            )

    def _steps(self, depth: int, code: int) -> list[int | None]:
        """By how much each state of the next variable raises the bound; None is impossible."""
        steps: list[int | None] = [0] * self._cards[depth]
        for table, least, cuts in self._readers[depth]:
            row = sum([((code >> shift) & mask) * stride for shift, mask, stride in cuts])
            base = int(least[row])
            for state, cost in enumerate(table[row].tolist()):
                before = steps[state]
                steps[state] = None if before is None or cost >= self._impossible else before + cost - base
        return steps


def _bounds(part: Part, scaled: Costs, order: Order, clock: Clock) -> tuple[int, dict[int, list[Mini]]]:
    """(a cost that none is below, the minis of every variable's bucket)."""
    turn = {v: i for i, v in enumerate(order.sequence)}
    waiting: dict[int, list[Term]] = {v: [] for v in order.sequence}
    for (scope, table), flat in zip(part.tables, scaled.tables, strict=True):
        waiting[min(scope, key=turn.__getitem__)].append((scope, flat.reshape(table.shape)))
    used = sum(_greatest(table, scaled.impossible) for table in scaled.tables)
    bits = _bits(part, order)
    bound = 0
    buckets: dict[int, list[Mini]] = {}
    for v in order.sequence:
        groups = in_groups(waiting.pop(v), part.cards, bits)
        tables = [_total(group, part.cards, turn, scaled.impossible) for group in groups]
        tables, used = _levelled(tables, used, scaled.impossible)
        buckets[v] = [Mini(scope, table, scaled.impossible) for scope, table in tables]
        for mini in buckets[v]:
            if len(mini.scope) == 1:
                bound += int(mini.least)
            else:
                waiting[min(mini.scope[:-1], key=turn.__getitem__)].append((mini.scope[:-1], mini.least))
        clock.check()
    return bound, buckets


def _bits(part: Part, order: Order) -> float:
    """The largest size of minis that keeps all of them in memory, as far as a rough count tells."""
    for bits in BITS:
        if math.log2(len(part.cards)) + min(bits, order.width) + 1.0 <= MINIS_BITS:
            return bits
    return BITS[-1]


def _total(group: Sequence[Term], cards: Sequence[int], turn: dict[int, int], impossible: int) -> Term:
    """The sum of a group, its axes by turn, latest first: the bucket's variable last."""
    scope = tuple(sorted({u for own, _ in group for u in own}, key=turn.__getitem__, reverse=True))
    place = {u: axis for axis, u in enumerate(scope)}
    total = np.zeros([cards[u] for u in scope], dtype=group[0][1].dtype)
    for own, table in group:
        total += aligned(own, table, place)
        np.minimum(total, impossible, out=total)
    return scope, total


def _levelled(tables: list[Term], used: int, impossible: int) -> tuple[list[Term], int]:
    """The same sum, every table with the same least cost of each state, and the cost ``used``.

    Unchanged where costs might reach ``impossible``.
    """
    if len(tables) < 2:
        return tables, used
    own = [table.min(axis=tuple(range(table.ndim - 1))) for _, table in tables]
    possible = np.logical_and.reduce([least < impossible for least in own])
    total = sum(np.where(possible, least, 0) for least in own)
    mean = total // len(tables)
    steps = [np.where(possible, mean - least, 0) for least in own]
    steps[0] += total - mean * len(tables)
    result = [
        (scope, np.where(table < impossible, table + step, impossible))
        for (scope, table), step in zip(tables, steps, strict=True)
    ]
    growth = sum(_greatest(t, impossible) for _, t in result) - sum(_greatest(t, impossible) for _, t in tables)
    grown = used + max(0, growth)
    return (tables, used) if grown >= impossible else (result, grown)


def _greatest(table: Table, impossible: int) -> int:
    return int(np.where(table < impossible, table, 0).max())
