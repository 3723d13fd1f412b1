"""The ranking of one connected piece: lazily ordered solutions of every bucket of its tree, under the exact heuristic.

The upward pass of max-elimination (min, on costs) tells for every cell of every bucket the least cost of all that lies
below it: a heuristic that is exact, so that best-first search opens nothing in vain. A *row* of a bucket is a joint
state of its separator; its solutions are the joint states of all variables below: a *column* (a joint state of the
residual) and a solution of a row of each child. Rows are shared by all that ask for them, and made when first asked
for.
"""

from __future__ import annotations

import functools
import heapq
import math
import operator
from typing import TYPE_CHECKING

import numpy as np

from plogic.inference.merge import Stream, nothing, product
from plogic.inference.ranked_tables import Cells, Coder, Digits, Joint, costs, least, placed, total

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.base.clock import Clock
    from plogic.inference.graph import Part
    from plogic.inference.order import Bucket
    from plogic.inference.ranked_tables import Table

_AXES = operator.attrgetter("ndim")
KEPT_COSTS = (
    1 << 24
)  # cells: the tables of larger trees are forgotten once their least costs are known, and made again row by row
SUMMED = 1 << 12  # cells up to which a bucket's tables are added up before they become costs


class Node:
    """One bucket: its axes, its costs of shape (rows, columns), the least cost of each row, and what it asks of its children."""

    def __init__(self, bucket: Bucket, cards: Sequence[int]) -> None:
        """Columns increase.

        So do the rows of a small bucket, as its tables' scopes do; those of a large one stay in the order in which its
        parent has them, so that nothing large is transposed.
        """
        rows, columns = bucket.scope[: bucket.shared], bucket.scope[bucket.shared :]
        self.small = math.prod([cards[v] for v in bucket.scope]) <= SUMMED
        self.rows, self.columns = tuple(sorted(rows) if self.small else rows), tuple(sorted(columns))
        self.place = {v: axis for axis, v in enumerate(self.rows + self.columns)}
        self.row_cards = [cards[v] for v in self.rows]
        self.column_cards = [cards[v] for v in self.columns]
        self.coder = Coder((), (), 0)
        self.children: list[tuple[Node, list[int], list[int]]] = []
        self.terms: list[Table] = []
        self.table: Table | None = None
        self.least: Table = np.zeros(0, dtype=np.int64)
        self.impossible = 0
        self.made: dict[int, Stream] = {}
        self.known: dict[int, list[int]] = {}

    def fill(self, terms: list[Table], impossible: int, digits: Digits, *, keep: bool) -> None:
        """Add up tables over the last axes, of full length or of length 1."""
        self.terms, self.impossible = terms, impossible
        self.coder = Coder([digits.places[v] for v in self.columns], self.column_cards, digits.shift)
        table = total(terms, self.row_cards + self.column_cards, impossible).reshape(math.prod(self.row_cards), -1)
        self.least = least(table)
        np.minimum(self.least, impossible, out=self.least)
        if keep:
            self.table, self.terms = table, []

    def costs(self, number: int) -> Table:
        """The costs of one row."""
        if self.table is not None:
            return self.table[number]
        at = _states(number, self.row_cards)
        axes = len(self.row_cards) + len(self.column_cards)
        rows = []
        for term in self.terms:
            own = zip(at[axes - term.ndim :], term.shape, strict=False)
            rows.append(term[tuple([state if length > 1 else 0 for state, length in own])])
        return total(rows, self.column_cards, self.impossible).reshape(-1)

    def link(self, child: Node) -> None:
        """Know how a row of the child follows from the own row and column: one stride an own axis."""
        stride, strides = 1, {}
        for v, card in zip(reversed(child.rows), reversed(child.row_cards), strict=True):
            strides[v] = stride
            stride *= card
        self.children.append((child, [strides.get(v, 0) for v in self.rows], [strides.get(v, 0) for v in self.columns]))

    def steps(self, column: int) -> list[int]:
        """By how much a column moves each child's row."""
        steps = self.known.get(column)
        if steps is None:
            states = _states(column, self.column_cards)
            steps = self.known[column] = [_dot(states, strides) for _, _, strides in self.children]
        return steps

    def row(self, number: int) -> Stream:
        """The solutions below one row."""
        stream = self.made.get(number)
        if stream is None:
            stream = Row(self, number) if self.children else Joint(self.costs(number), self.coder, self.impossible)
            self.made[number] = stream
        return stream


class Row(Stream):
    """A row with children: every column's solutions, merged; a column is opened once its least cost may be the next."""

    __slots__ = ("_after", "_bases", "_cells", "_first", "_heap", "_node", "_opened")

    def __init__(self, node: Node, number: int) -> None:
        super().__init__()
        self._node = node
        self._cells = Cells(node.costs(number), node.impossible)
        self._opened = 0
        self._first: int | None = None  # least solution of the next column conceivable, with all states below 0
        self._heap: list[tuple[int, int, int, Stream]] = []
        self._after: tuple[int, int, int, Stream] | None = (
            None  # (column, the column's own share, rank, solutions below) to look at next
        )
        states = _states(number, node.row_cards)
        self._bases = [_dot(states, strides) for _, strides, _ in node.children]

    def advance(self) -> tuple[Stream, int] | None:
        """Put the next solution of the last column in the heap, open columns that may come before, then take the first."""
        while True:
            after = self._after or self._next_column()
            if after is None:
                break
            column, own, rank, below = self._after = after
            if len(below.found) <= rank and not below.done:
                return below, rank
            if rank < len(below.found):
                heapq.heappush(self._heap, (own + below.found[rank], column, rank, below))
            self._after = None
        if not self._heap:
            self.done = True
            return None
        solution, column, rank, below = heapq.heappop(self._heap)
        self.found.append(solution)
        self._after = (column, solution - below.found[rank], rank + 1, below)
        return None

    def _next_column(self) -> tuple[int, int, int, Stream] | None:
        """The next column, opened.

        None if there is none, or the first in the heap comes before all that it may have.
        """
        node, cells, opened, first = self._node, self._cells, self._opened, self._first
        if first is None:
            if not cells.reach(opened):
                return None
            first = self._first = (cells.costs[opened] << node.coder.shift) + node.coder.code(cells.numbers[opened])
        if self._heap and self._heap[0][0] < first:
            return None
        column = cells.numbers[opened]
        self._opened, self._first = opened + 1, None
        streams, below = [], 0
        for base, step, (child, _, _) in zip(self._bases, node.steps(column), node.children, strict=True):
            streams.append(child.row(base + step))
            below += int(child.least[base + step])
        return column, first - (below << node.coder.shift), 0, product(streams)


def component(part: Part, buckets: Sequence[Bucket], digits: Digits, clock: Clock) -> tuple[float, Stream]:
    """(log weight of cost 0, the solutions of one piece); OutOfTimeError past the clock."""
    cards = part.cards
    nodes = [Node(bucket, cards) for bucket in buckets]
    entering = [_entering(part, bucket, node) for bucket, node in zip(buckets, nodes, strict=True)]
    scaled = costs([table for tables in entering for table in tables])
    if scaled is None:
        return 0.0, nothing()
    tables = iter(scaled.tables)
    digits = Digits(digits.places, digits.shift + scaled.shift)
    keep = sum(math.prod(node.row_cards + node.column_cards) for node in nodes) <= KEPT_COSTS
    for bucket, node, own in zip(buckets, nodes, entering, strict=True):
        terms = [next(tables).reshape(table.shape) for table in own]
        for child in [nodes[i] for i in bucket.children]:
            terms.append(placed(child.rows, child.least, node.place, cards))
            node.link(child)
        node.fill(terms, scaled.impossible, digits, keep=keep)
        clock.check()
    return scaled.top, product([node.row(0) for node, bucket in zip(nodes, buckets, strict=True) if bucket.parent < 0])


def _entering(part: Part, bucket: Bucket, node: Node) -> list[NDArray[np.float64]]:
    """The log weights that enter a bucket, with its node's axes; of a small bucket their sum."""
    terms = [placed(*part.tables[i], node.place, part.cards) for i in bucket.tables]
    if terms and node.small:
        return [functools.reduce(operator.add, sorted(terms, key=_AXES))]  # those that need the fewest cells first
    return terms


def _states(number: int, cards: Sequence[int]) -> list[int]:
    """The states whose joint state has this number, the last fastest."""
    result = []
    for card in reversed(cards):
        number, state = divmod(number, card)
        result.append(state)
    return result[::-1]


def _dot(states: Sequence[int], strides: Sequence[int]) -> int:
    return sum([state * stride for state, stride in zip(states, strides, strict=True)])
