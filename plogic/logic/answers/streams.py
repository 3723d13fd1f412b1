"""Independent streams of weighted states, merged lazily: the best combinations first, however many there are (Lawler, Murty)."""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING

from plogic.logic.answers.independent_factors import bucket

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.logic.answers.independent_factors import State

Item = tuple[float, tuple["State", ...]]
"""Log weight, and one state of each stream."""


class Single:
    """A stream as a list that grows when it is read."""

    def __init__(self, states: Iterator[tuple[float, State]]) -> None:
        self.states = states
        self.items: list[Item] = []

    def get(self, i: int) -> Item | None:
        """The i-th best, from 0; None past the last."""
        while len(self.items) <= i:
            found = next(self.states, None)
            if found is None:
                return None
            self.items.append((found[0], (found[1],)))
        return self.items[i]


class Pair:
    """The combinations of two streams, non-increasing; ties by the first stream's place, then the second's."""

    def __init__(self, left: Stream, right: Stream) -> None:
        self.left, self.right = left, right
        self.items: list[Item] = []
        self.queue: list[tuple[float, int, int]] = []
        self._push(0, 0)

    def get(self, i: int) -> Item | None:
        """The i-th best, from 0; None past the last."""
        while len(self.items) <= i:
            if not self.queue:
                return None
            _, a, b = heapq.heappop(self.queue)
            first, second = self.left.get(a), self.right.get(b)
            if first is not None and second is not None:
                self.items.append((first[0] + second[0], (*first[1], *second[1])))
            self._push(a, b + 1)
            if b == 0:
                self._push(a + 1, 0)
        return self.items[i]

    def _push(self, a: int, b: int) -> None:
        first, second = self.left.get(a), self.right.get(b)
        if first is not None and second is not None:
            heapq.heappush(self.queue, (-bucket(first[0] + second[0]), a, b))


Stream = Single | Pair


def merged(streams: list[Iterator[tuple[float, State]]]) -> Iterator[Item]:
    """All combinations of one state of each stream, non-increasing in the sum of log weights; of no streams, the empty one."""
    level: list[Stream] = [Single(states) for states in streams]
    if not level:
        yield 0.0, ()
        return
    while len(level) > 1:
        pairs: list[Stream] = [Pair(left, right) for left, right in zip(level[::2], level[1::2], strict=False)]
        level = pairs + level[len(level) - len(level) % 2 :]
    i = 0
    while (item := level[0].get(i)) is not None:
        yield item
        i += 1
