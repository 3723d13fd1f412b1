"""Which variables to fix, so that the rest has small tables (J. Pearl's conditioning; loop-cutset and w-cutset of Dechter)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from plogic.inference.order import Order, elimination_order, members, order_along
from plogic.inference.tree import bucket_tree

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.base.clock import Clock
    from plogic.inference.parts import Part
    from plogic.inference.tree import Bucket


class Cutset(NamedTuple):
    """``fixed``, in the order of their choice; ``cards`` with 1 for them; ``order`` and ``buckets`` of the rest (each fixed one stands alone)."""

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
    """The tables of an order that are too wide; ``gain``: per variable, the cells (of the widest) of those that it is in."""

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
