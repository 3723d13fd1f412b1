"""The sum and the beliefs of one connected piece: exact where its tables are small enough and time allows, else case by case.

Exact: by the table of all joint states, or by two passes over a tree of buckets. Case by case: the variables of a
cutset are fixed, so that the rest has small tables (J. Pearl's conditioning; loop-cutset and w-cutset of Dechter).
"""

from __future__ import annotations

import math
from contextlib import suppress
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from plogic.base.clock import OutOfTimeError
from plogic.base.errors import WidthError
from plogic.inference.conditioning import conditioned, glanced, hasty
from plogic.inference.graph import Beliefs
from plogic.inference.order import BUCKET_CELLS, Bucket, Order, bucket_tree, elimination_order, members, order_along
from plogic.inference.passes import joint, two_way

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.base.clock import Clock
    from plogic.inference.graph import Part
    from plogic.inference.passes import Solved


class Cutset(NamedTuple):
    """``fixed``, in the order of their choice; ``cards`` with 1 for them.

    ``order`` and ``buckets`` of the rest (each fixed one stands alone).
    """

    fixed: tuple[int, ...]
    cards: tuple[int, ...]
    order: Order
    buckets: tuple[Bucket, ...]

    def work(self, cards: Sequence[int]) -> float:
        """log2 of the cells of all cases together."""
        return self.order.work + sum(math.log2(cards[v]) for v in self.fixed)


def cutset(part: Part, order: Order, width: float, most: float, clock: Clock) -> Cutset | None:
    """Variables whose fixing brings the order's largest table to ``width`` bits: greedily those in the most cells that are too wide.

    None where they would have more than 2^``most`` joint states; OutOfTimeError past the clock.
    """
    cliques = _Cliques(part.cards, order, width)
    fixed: list[int] = []
    states = 0.0
    while cliques.wide:
        clock.check()
        best = max(range(len(part.cards)), key=lambda u: (cliques.gain[u], -u))
        states += math.log2(part.cards[best])
        if states > most:
            return None
        fixed.append(best)
        cliques.fix(best)
    return _cutset(part, order, fixed, width, clock)


class _Cliques:
    """The tables of an order that are too wide.

    ``gain``: per variable, the cells (of the widest) of those that it is in.
    """

    def __init__(self, cards: Sequence[int], order: Order, width: float) -> None:
        self.width = width
        self.bits = [math.log2(card) for card in cards]
        self.top = order.width
        self.gain = [0.0] * len(cards)
        masks = {v: (1 << v) | order.rests[v] for v in order.sequence}
        sizes = {v: sum(self.bits[u] for u in members(mask)) for v, mask in masks.items()}
        self.wide = {v: (mask, sizes[v]) for v, mask in masks.items() if sizes[v] > width}
        for mask, size in self.wide.values():
            self._count(mask, 2.0 ** (size - self.top))

    def _count(self, mask: int, cells: float) -> None:
        for u in members(mask):
            self.gain[u] += cells

    def fix(self, variable: int) -> None:
        """Takes a variable out of every table."""
        for v, (mask, size) in list(self.wide.items()):
            if mask >> variable & 1:
                self._count(mask, -(2.0 ** (size - self.top)))
                rest, less = mask & ~(1 << variable), size - self.bits[variable]
                if less > self.width:
                    self.wide[v] = rest, less
                    self._count(rest, 2.0 ** (less - self.top))
                else:
                    del self.wide[v]
        self.gain[variable] = -math.inf


def _cutset(part: Part, order: Order, fixed: Sequence[int], width: float, clock: Clock) -> Cutset:
    """With a new order for the rest, or the given one where the new one is too wide."""
    gone = set(fixed)
    cards = tuple([1 if v in gone else card for v, card in enumerate(part.cards)])
    scopes = [tuple([v for v in scope if v not in gone]) for scope, _ in part.tables]
    told = [scope for scope in scopes if scope]
    best = elimination_order(cards, told, clock.check)
    if best.width > width:
        best = order_along(cards, told, order.sequence)
    return Cutset(tuple(fixed), cards, best, bucket_tree(cards, told, best))


def small(part: Part, width: float = math.inf) -> bool:
    """Whether one table of all joint states is the fastest way, and within ``width`` bits."""
    cells = math.prod(part.cards)
    return cells <= BUCKET_CELLS and math.log2(cells) <= width


def planned(part: Part, clock: Clock) -> tuple[Order, tuple[Bucket, ...]]:
    """The elimination order of a piece, and its buckets; OutOfTimeError past the clock."""
    scopes = tuple([scope for scope, _ in part.tables])
    return plan(part.cards, scopes) if clock.end is None else _plan(part.cards, scopes, clock.check)


@lru_cache(maxsize=64)
def plan(cards: tuple[int, ...], scopes: tuple[tuple[int, ...], ...]) -> tuple[Order, tuple[Bucket, ...]]:
    """The last ones are remembered, for a scene is often asked again with other numbers."""
    return _plan(cards, scopes, lambda: None)


def _plan(
    cards: tuple[int, ...], scopes: tuple[tuple[int, ...], ...], check: Callable[[], None]
) -> tuple[Order, tuple[Bucket, ...]]:
    order = elimination_order(cards, scopes, check)
    return order, bucket_tree(cards, scopes, order)


EFFORT = 32.0  # bits: cells of all cases together that are still solved without a deadline; about a minute
PACE = 1 << 26  # cells a second, a guess; only what to try before a deadline depends on it, no result
BUCKET_SECONDS = 2e-4  # seconds that a bucket takes besides; likewise
ATTEMPT = 0.75  # share of the time that is left in which an exact attempt should end, and after which it is given up
PRUNE = 5.0  # bits of the tables that see that a case is impossible
MOST_CUT_BITS = 64.0  # bits of fixed variables; more cases than that are not begun
BUCKET = 14.0  # bits, at most, of those that bound the cases not looked at


def bounded(part: Part, width: float, clock: Clock) -> Beliefs:
    """A piece, exactly or (only with a limit of time) as an interval; WidthError where it is hopeless without one."""
    try:
        clock.check()
        if small(part, width):
            return _one(joint(part.cards, part.tables))
        order, buckets = planned(part, clock)
        if order.width <= width and _fair(order.work, len(buckets), clock):
            with suppress(OutOfTimeError):
                return _one(two_way(part.cards, part.tables, buckets, clock.some(ATTEMPT).check))
        return _cases(part, order, width, clock)
    except OutOfTimeError:
        return hasty(part)


def _fair(work: float, buckets: float, clock: Clock) -> bool:
    """Whether tables of 2^``work`` cells in so many buckets should be done in time."""
    return clock.end is None or work <= _bits(ATTEMPT * clock.left() - buckets * BUCKET_SECONDS)


def _bits(seconds: float) -> float:
    """log2 of the cells that a time allows."""
    return math.log2(max(seconds * PACE, 1.0))


def _one(solved: Solved) -> Beliefs:
    log_z, beliefs = solved
    return Beliefs((log_z, log_z), beliefs, beliefs)


def _cases(part: Part, order: Order, width: float, clock: Clock) -> Beliefs:
    if clock.end is None:
        cut = cutset(part, order, width, EFFORT, clock)
        if cut is None or cut.work(part.cards) > EFFORT:
            raise WidthError(_hopeless(part, order, width))
        return conditioned(part, cut, PRUNE, clock)
    budget = _bits(clock.left() / 2)
    bits = min(width, BUCKET, max(PRUNE, budget - 14.0))
    cut = cutset(part, order, width, MOST_CUT_BITS, clock)
    if cut and not _fair(cut.work(part.cards), math.prod(part.cards[v] for v in cut.fixed) * len(cut.buckets), clock):
        cut = cutset(part, order, min(width, max(6.0, budget - 8.0)), MOST_CUT_BITS, clock) or cut
    return conditioned(part, cut, bits, clock) if cut else glanced(part, order.sequence, bits, clock)


def _hopeless(part: Part, order: Order, width: float) -> str:
    return (
        f"{len(part.cards)} variables hang together so closely that exact sums need tables of {order.width:.1f} bits "
        f"(the limit is {width:g}), and more than 2^{EFFORT:g} cells case by case; with a deadline (seconds) the answer is intervals"
    )
