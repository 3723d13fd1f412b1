"""Ordered lists of solutions that are made as far as they are asked for, and the ordered sums of such lists.

A *solution* is one integer: its cost (units below the best log weight conceivable) above, its code below. In the code
every variable has its own place, so that the order of solutions is by cost, then lexicographic by states; and solutions
of independent parts are simply added. Hence the k-th best of a whole needs few solutions of its parts (E. Lawler, A
procedure for computing the K best solutions to discrete optimization problems, 1972; L. Huang and D. Chiang, Better
k-best parsing, 2005).

Streams ask for what they need instead of calling each other: a chain of thousands of them does not deepen Python's
stack.
"""

import heapq
from collections.abc import Iterator, Sequence

from plogic.base.clock import Clock

STEPS_A_LOOK = 64  # steps between two looks at the clock


class Stream:
    """Solutions in order: ``found`` so far; ``done`` when there are no more."""

    __slots__ = ("done", "found")

    def __init__(self) -> None:
        self.found: list[int] = []
        self.done = False

    def advance(self) -> "tuple[Stream, int] | None":
        """Come nearer to the next solution; or say which solution (stream, rank) must be found before."""
        raise NotImplementedError


def nothing() -> Stream:
    """A stream without solutions."""
    stream = Stream()
    stream.done = True
    return stream


class Product(Stream):
    """The sums of all pairs of two streams' solutions."""

    __slots__ = ("_after", "_heap", "_left", "_right")

    def __init__(self, left: Stream, right: Stream) -> None:
        super().__init__()
        self._left, self._right = left, right
        self._heap: list[tuple[int, int, int]] = []
        self._after = [(0, 0)]  # pairs of ranks that must enter the heap before the next solution is known

    def advance(self) -> tuple[Stream, int] | None:
        """Put the successors of the last pair in the heap, then take the first."""
        left, right, after = self._left, self._right, self._after
        while after:
            i, j = after[-1]
            if len(left.found) <= i and not left.done:
                return left, i
            if len(right.found) <= j and not right.done:
                return right, j
            after.pop()
            if i < len(left.found) and j < len(right.found):
                heapq.heappush(self._heap, (left.found[i] + right.found[j], i, j))
        if not self._heap:
            self.done = True
            return None
        solution, i, j = heapq.heappop(self._heap)
        self.found.append(solution)
        after.append((i, j + 1))
        if j == 0:
            after.append((i + 1, 0))
        return None


def product(streams: Sequence[Stream]) -> Stream:
    """All sums of one solution of each of at least one stream, by a balanced tree of pairs."""
    level = list(streams)
    while len(level) > 1:
        pairs: list[Stream] = [Product(a, b) for a, b in zip(level[::2], level[1::2], strict=False)]
        level = pairs + level[len(level) & ~1 :]
    return level[0]


def sums(streams: Sequence[Stream], clock: Clock) -> Iterator[int]:
    """All sums of one solution of each stream, least first; OutOfTimeError past the clock.

    Three successors a sum, however many streams: they are ordered by what the step from the first to the second
    solution costs, and a sum remembers the last of them that it moved, and how far.
    """
    clock.check()
    if len(streams) == 1:
        yield from _alone(streams[0], clock)
        return
    if not all(reach(stream, 0, clock) for stream in streams):
        return
    least = sum([stream.found[0] for stream in streams])
    yield least
    lists = sorted(
        [stream for stream in streams if reach(stream, 1, clock)], key=lambda stream: stream.found[1] - stream.found[0]
    )
    steps = [stream.found[1] - stream.found[0] for stream in lists]
    heap = [(least + steps[0], 0, 1)] if steps else []
    while heap:
        clock.check()
        total, i, rank = heapq.heappop(heap)
        yield total
        if reach(lists[i], rank + 1, clock):
            found = lists[i].found
            heapq.heappush(heap, (total + found[rank + 1] - found[rank], i, rank + 1))
        if i + 1 < len(lists):
            heapq.heappush(heap, (total + steps[i + 1], i + 1, 1))
            if rank == 1:
                heapq.heappush(heap, (total - steps[i] + steps[i + 1], i + 1, 1))


def _alone(stream: Stream, clock: Clock) -> Iterator[int]:
    rank = 0
    while reach(stream, rank, clock):
        yield stream.found[rank]
        rank += 1
        clock.check()


def reach(stream: Stream, rank: int, clock: Clock) -> bool:
    """Find the solution of a rank; whether there is one."""
    if len(stream.found) > rank:
        return True
    if not stream.done:
        need = stream.advance()
        if len(stream.found) <= rank and not stream.done:
            _find([(stream, rank)] if need is None else [(stream, rank), need], clock)
    return len(stream.found) > rank


def _find(stack: list[tuple[Stream, int]], clock: Clock) -> None:
    """Find the first solution of the stack by way of those above it, which are needed before."""
    turns = 0
    while stack:
        now, k = stack[-1]
        if len(now.found) > k or now.done:
            stack.pop()
            continue
        need = now.advance()
        if need is not None:
            stack.append(need)
        turns += 1
        if turns % STEPS_A_LOOK == 0:
            clock.check()
