"""Two passes over a tree of buckets: up, what each tells its parent; down, the belief that each hands to its children.

On the way down a bucket multiplies its parent's belief of the separator by P(residual | separator), which it kept from
the way up: beliefs only ever shrink sums that are at most 1, so nothing overflows, and what underflows is less than
1e-300 of the whole.

A bucket tells its parent the product of what enters it, summed over its residual. A small table, and one whose entries
differ by more than floats can hold, is multiplied as logarithms. A large one is multiplied as plain numbers, several
times faster, but only where the spreads of all that enters it (ln of greatest over least positive entry, measured) sum
to less than ``MOST_SPREAD``: then no positive product can underflow, and both ways agree to rounding.

* ``Message(values)``: what enters a bucket, a given table or what a child tells; the scale that was taken out of it is
  kept apart
* ``Weighed(weights, totals)``: shape (separator, residual) and (separator,): weights ÷ totals is P(residual |
  separator)
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby

import numpy as np
from numpy.typing import NDArray

from plogic.inference.graph import Tables, aligned
from plogic.inference.order import Bucket

Solved = tuple[float, tuple[NDArray[np.float64], ...]]

MOST_SPREAD = 600.0  # e^-600 is 1e-261: far above the least positive double, 1e-308
LARGE_PRODUCT = 1 << 12  # cells from which plain numbers pay
FEW_COLUMNS = 16  # columns that are rather taken one by one
RUN_CELLS = 1 << 10  # cells of the contiguous runs in which a small table is multiplied into a large one


@dataclass
class Message:
    """``values`` as logarithms (``log``), impossible −inf, or plain with greatest 1, impossible 0.

    ``spread``: ≥ ln(greatest ÷ least positive).

    ``top`` is the greatest logarithm, known once it is ``measured``.
    """

    values: NDArray[np.float64]
    log: bool = True
    spread: float = math.inf
    top: float = 0.0

    def measured(self) -> float:
        """The spread; looks at the values where what is known is of no use."""
        if self.spread > MOST_SPREAD / 2:
            possible = self.values[self.values > (-np.inf if self.log else 0.0)]
            if not possible.size:
                self.spread = 0.0
            elif self.log:
                self.top = float(possible.max())
                self.spread = self.top - float(possible.min())
            else:
                self.spread = -math.log(possible.min())
        return self.spread

    def plain(self) -> NDArray[np.float64]:
        """Plain numbers, e^−``top`` times; only where a measured spread allows it."""
        return np.exp(self.values - self.top) if self.log else self.values

    def logs(self) -> NDArray[np.float64]:
        """Natural logarithms."""
        return self.values if self.log else np.log(self.values)


@dataclass
class Weighed:
    """A bucket's own table, kept for the way down."""

    weights: NDArray[np.float64]
    totals: NDArray[np.float64]


def weigh(entering: Sequence[Message], shape: Sequence[int], shared: int) -> tuple[Weighed, Message, float] | None:
    """(the table, the message over its first ``shared`` axes, the log scale taken out); None if nothing is possible.

    What enters has as many axes as ``shape``, of its length or 1.
    """
    rows, columns = math.prod(shape[:shared]), math.prod(shape[shared:])
    if rows * columns >= LARGE_PRODUCT:
        spread = sum(message.measured() for message in entering)
        if spread < MOST_SPREAD:
            return _plain(entering, shape, rows, spread)
    return _log(entering, shape, rows)


def _log(entering: Sequence[Message], shape: Sequence[int], rows: int) -> tuple[Weighed, Message, float] | None:
    table = np.zeros(shape)
    for message in entering:
        table += message.logs()
    weights = table.reshape(rows, -1)
    tops = weights.max(axis=1)
    top = tops.max()
    if top == -np.inf:
        return None
    if rows == 1:
        weights = np.exp(weights - top)
        totals = weights.sum(axis=1)
        return Weighed(weights, totals), Message(np.zeros(1)), float(top) + math.log(totals[0])
    tops[tops == -np.inf] = 0.0
    weights -= tops[:, None]
    np.exp(weights, out=weights)
    totals = weights.sum(axis=1)
    values = np.log(totals) + tops
    top = float(values.max())
    values -= top
    return Weighed(weights, totals), Message(values), top


def _plain(
    entering: Sequence[Message], shape: Sequence[int], rows: int, spread: float
) -> tuple[Weighed, Message, float] | None:
    weights = _product([message.plain() for message in entering], shape).reshape(rows, -1)
    totals = row_sums(weights)
    top = float(totals.max())
    if top == 0.0:
        return None
    message = Message(totals / top, log=False, spread=spread + math.log(weights.shape[1]))
    return Weighed(weights, totals), message, math.log(top) + math.fsum(one.top for one in entering)


def row_sums(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum of each row of a table with many rows: by columns, where numpy would start anew for every short row."""
    if table.shape[1] > FEW_COLUMNS:
        return np.add.reduce(table, axis=1)
    totals = table[:, 0].copy()
    for column in range(1, table.shape[1]):
        totals += table[:, column]
    return totals


def column_sums(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum of each column, likewise."""
    if table.shape[1] > FEW_COLUMNS:
        return np.add.reduce(table, axis=0)
    return np.array([np.add.reduce(table[:, column]) for column in range(table.shape[1])])


def _product(arrays: Sequence[NDArray[np.float64]], shape: Sequence[int]) -> NDArray[np.float64]:
    """The product over the whole shape: the small ones first, in contiguous runs, then the large ones in place."""
    ordered = sorted(arrays, key=lambda a: a.size)
    small = np.ones((1,) * len(shape))
    while ordered and ordered[0].size < RUN_CELLS:
        small = small * ordered.pop(0)
    table = np.empty(shape)
    if not ordered:
        table[...] = runs(small, shape)
        return table
    np.multiply(ordered[-1], runs(small, shape), out=table)
    for large in ordered[:-1]:
        table *= runs(large, shape)
    return table


def runs(array: NDArray[np.float64], shape: Sequence[int]) -> NDArray[np.float64]:
    """The array repeated along its last axes, so that a product with it runs over contiguous blocks."""
    target = list(array.shape)
    cells, axis = 1, len(shape)
    while axis and cells < RUN_CELLS:
        axis -= 1
        target[axis] = shape[axis]
        cells *= shape[axis]
    return np.ascontiguousarray(np.broadcast_to(array, target)) if list(array.shape) != target else array


KEPT_CELLS = 1 << 25  # cells: larger trees forget their tables on the way up, and weigh each again on the way down
HELD = 1 << 27  # cells: still larger ones forget most messages too, lest they fill gigabytes
_WHOLE = np.ones(1)


def two_way(cards: Sequence[int], tables: Tables, buckets: Sequence[Bucket], check: Callable[[], None]) -> Solved:
    """(ln of the sum of all weights, the belief of every variable); (−inf, NaN arrays) if nothing is possible.

    ``check`` may raise.
    """
    passes = _Passes(cards, tables, buckets)
    with np.errstate(divide="ignore"):
        log_z = passes.up(check)
        return log_z, impossible(cards) if log_z == -math.inf else passes.down(check)


def impossible(cards: Sequence[int]) -> tuple[NDArray[np.float64], ...]:
    """NaN beliefs."""
    return tuple([np.full(card, np.nan) for card in cards])


def joint(cards: Sequence[int], tables: Tables) -> Solved:
    """The same by one table of all joint states: the definition, and for few cells the fastest way."""
    table = np.zeros(cards)
    for scope, factor in tables:
        shape = [1] * len(cards)
        for v in scope:
            shape[v] = cards[v]
        table += factor.reshape(shape)
    top = float(table.max())
    if top == -math.inf:
        return top, impossible(cards)
    table -= top
    np.exp(table, out=table)
    total = float(np.add.reduce(table, axis=None))
    table /= total
    return top + math.log(total), singles(table.reshape(-1), cards)


def singles(table: NDArray[np.float64], cards: Sequence[int]) -> tuple[NDArray[np.float64], ...]:
    """The sums of a joint belief for each of its axes, none above 1 by rounding: each axis is summed away after its own."""
    flat = np.empty(sum(cards))
    ends = list(accumulate(cards))
    for card, end in zip(cards[:-1], ends, strict=False):
        table = table.reshape(card, -1)
        np.add.reduce(table, axis=1, out=flat[end - card : end])
        table = np.add.reduce(table, axis=0)
    flat[ends[-1] - cards[-1] :] = table
    np.minimum(flat, 1.0, out=flat)
    flat.flags.writeable = False
    return tuple([flat[end - card : end] for card, end in zip(cards, ends, strict=True)])


class _Passes:
    """Messages by bucket.

    Of a tree past ``HELD``, those inside a stretch of buckets are dropped, and found again when the way down gets
    there.
    """

    def __init__(self, cards: Sequence[int], tables: Tables, buckets: Sequence[Bucket]) -> None:
        self.cards, self.tables, self.buckets = cards, tables, buckets
        self.messages: list[Message | None] = [None] * len(buckets)
        self.kept: list[Weighed | None] = [None] * len(buckets)
        cells = sum(math.prod(cards[v] for v in bucket.scope) for bucket in buckets)
        self.keep = cells <= KEPT_CELLS
        length = len(buckets) if cells <= HELD else math.isqrt(len(buckets)) + 1
        self.stretches = [range(start, min(start + length, len(buckets))) for start in range(0, len(buckets), length)]

    def up(self, check: Callable[[], None]) -> float:
        """The logarithm of the sum of all weights."""
        scales = []
        for stretch in self.stretches:
            for number in stretch:
                check()
                weighed = self.weigh(self.buckets[number])
                if weighed is None:
                    return -math.inf
                self.kept[number] = weighed[0] if self.keep else None
                self.messages[number] = weighed[1]
                scales.append(weighed[2])
            if len(self.stretches) > 1:
                self.drop(stretch)
        return math.fsum(scales)

    def drop(self, stretch: range) -> None:
        """Forgets the messages that are told within a stretch of buckets."""
        for number in stretch:
            if self.buckets[number].parent in stretch:
                self.messages[number] = None

    def find(self, stretch: range, check: Callable[[], None]) -> None:
        """Weighs again what was dropped."""
        for number in stretch:
            if self.messages[number] is None:
                check()
                self.messages[number] = self.weighed(number)[1]

    def weighed(self, number: int) -> tuple[Weighed, Message, float]:
        """A bucket that was possible on the way up, weighed again."""
        again = self.weigh(self.buckets[number])
        assert again is not None  # noqa: S101 - the same numbers in the same order
        return again

    def weigh(self, bucket: Bucket) -> tuple[Weighed, Message, float] | None:
        position = {v: axis for axis, v in enumerate(bucket.scope)}
        entering = [Message(aligned(*self.tables[i], position)) for i in bucket.tables]
        for child in bucket.children:
            message, inner = self.messages[child], self.buckets[child]
            assert message is not None  # noqa: S101 - children come first
            shape = [1] * len(position)
            for v in inner.scope[: inner.shared]:
                shape[position[v]] = self.cards[v]
            entering.append(Message(message.values.reshape(shape), message.log, message.spread))
        return weigh(entering, [self.cards[v] for v in bucket.scope], bucket.shared)

    def down(self, check: Callable[[], None]) -> tuple[NDArray[np.float64], ...]:
        """The belief of every variable."""
        beliefs: list[NDArray[np.float64]] = [np.empty(0)] * len(self.cards)
        handed: dict[int, NDArray[np.float64]] = {}
        for stretch in reversed(self.stretches):
            self.find(stretch, check)
            for number in reversed(stretch):
                check()
                self.tell(number, self._believed(number, handed.pop(number, _WHOLE)), beliefs, handed)
        return tuple(beliefs)

    def tell(
        self,
        number: int,
        table: NDArray[np.float64],
        beliefs: list[NDArray[np.float64]],
        handed: dict[int, NDArray[np.float64]],
    ) -> None:
        """A bucket's joint belief, summed for its own variables and for each child's separator."""
        bucket = self.buckets[number]
        own = bucket.scope[bucket.shared :]
        residual = column_sums(table)
        residual /= residual.sum()
        for v, belief in zip(own, singles(residual, [self.cards[v] for v in own]), strict=True):
            beliefs[v] = belief
        for child in bucket.children:
            inner = self.buckets[child]
            handed[child] = _summed(
                table, [self.cards[v] for v in bucket.scope], bucket.scope, inner.scope[: inner.shared]
            )
            self.messages[child] = None

    def _believed(self, number: int, belief: NDArray[np.float64]) -> NDArray[np.float64]:
        """The joint belief of a bucket, shape (separator, residual), from the belief of its separator."""
        weighed = self.kept[number] or self.weighed(number)[0]
        self.kept[number] = None
        totals = weighed.totals
        totals[totals == 0.0] = 1.0
        ratio = belief / totals
        table = weighed.weights
        if table.shape[1] <= FEW_COLUMNS and table.shape[0] > RUN_CELLS:
            for column in range(table.shape[1]):
                table[:, column] *= ratio
        else:
            table *= ratio[:, None]
        return table


def _summed(
    table: NDArray[np.float64], shape: Sequence[int], scope: Sequence[int], kept: Sequence[int]
) -> NDArray[np.float64]:
    """The table summed over all axes but ``kept`` (in the order of the scope), flat; neighbouring axes go together."""
    keep = set(kept)
    runs = groupby(zip(scope, shape, strict=True), key=lambda one: one[0] in keep)
    lengths = [(math.prod([length for _, length in run]), kind) for kind, run in runs]
    after = 1
    for length, kind in reversed(lengths):
        if kind:
            after *= length
        else:
            table = _axis_summed(table.reshape(-1, length, after))
    return table.reshape(-1)


def _axis_summed(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shape (before, length, after) summed over its middle axis."""
    if table.shape[1] > FEW_COLUMNS or table.size < RUN_CELLS:
        return np.add.reduce(table, axis=1)
    if table.shape[1] == 1:
        return table[:, 0]
    if table.shape[2] == 1:
        return row_sums(table[:, :, 0])
    total = table[:, 0] + table[:, 1]
    for state in range(2, table.shape[1]):
        total += table[:, state]
    return total
