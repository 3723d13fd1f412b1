"""The ranking of one connected piece: by exact tables, or, where it is too wide for them, by A* under mini-bucket bounds.

The upward pass of max-elimination (min, on costs) tells for every cell of every bucket the least cost of all that lies
below it: a heuristic that is exact, so that best-first search opens nothing in vain. A *row* of a bucket is a joint
state of its separator; its solutions are the joint states of all variables below: a *column* (a joint state of the
residual) and a solution of a row of each child. Rows are shared by all that ask for them, and made when first asked
for.

In a wide piece, a bucket whose table would be too large is split into *minis* of few enough cells, each of which takes
its own minimum over the bucket's variable: the sum of minima is no more than the minimum of the sum, so it is a bound
that never overestimates a cost (R. Dechter and I. Rish, Mini-buckets, 2003), and A* under it finds all solutions in
exact order, after opening more nodes than needed. The bounds are tightened by levelling the minis of a bucket: each
gets the mean of their least costs per state (A. Ihler et al., Join-graph based cost-shifting schemes, 2012), which
leaves their sum as it is.
"""

import functools
import heapq
import math
import operator
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plogic.base.clock import Clock
from plogic.base.errors import LimitError
from plogic.inference.graph import Part, aligned, in_groups
from plogic.inference.merge import Stream, nothing, product
from plogic.inference.order import Bucket, Order
from plogic.inference.ranked_tables import Cells, Coder, Costs, Digits, Joint, Table, costs, least, placed, total

Term = tuple[tuple[int, ...], Table]  # variables of the piece, one axis each

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
        places = (zip(at[axes - term.ndim :], term.shape, strict=False) for term in self.terms)
        rows = [
            term[tuple([state if length > 1 else 0 for state, length in own])]
            for term, own in zip(self.terms, places, strict=True)
        ]
        return total(rows, self.column_cards, self.impossible).reshape(-1)

    def link(self, child: "Node") -> None:
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
        for table, lowest, cuts in self._readers[depth]:
            row = sum([((code >> shift) & mask) * stride for shift, mask, stride in cuts])
            base = int(lowest[row])
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
    rows = math.log2(len(part.cards))
    return next((bits for bits in BITS if rows + min(bits, order.width) + 1.0 <= MINIS_BITS), BITS[-1])


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
