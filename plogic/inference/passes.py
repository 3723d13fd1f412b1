"""Two passes over a tree of buckets: up, what each tells its parent; down, the belief that each hands to its children.

On the way down a bucket multiplies its parent's belief of the separator by P(residual | separator), which it kept from
the way up: beliefs only ever shrink sums that are at most 1, so nothing overflows, and what underflows is less than
1e-300 of the whole.
"""

from __future__ import annotations

import math
from itertools import accumulate, groupby
from typing import TYPE_CHECKING

import numpy as np

from plogic.inference.axes import aligned
from plogic.inference.messages import FEW_COLUMNS, RUN_CELLS, Message, Weighed, column_sums, row_sums, weigh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from plogic.inference.graph import Tables
    from plogic.inference.order import Bucket

    Solved = tuple[float, tuple[NDArray[np.float64], ...]]

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
                table = self._believed(number, handed.pop(number, _WHOLE))
                self.tell(number, table, beliefs, handed)
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
