"""One connected piece, solved exactly: by its table of all joint states, or by two passes over a tree of buckets."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

from plogic.inference.order import Order, elimination_order
from plogic.inference.passes import joint, two_way
from plogic.inference.tree import CELLS, Bucket, bucket_tree

if TYPE_CHECKING:
    from collections.abc import Callable

    from plogic.base.clock import Clock
    from plogic.inference.parts import Part
    from plogic.inference.passes import Solved


def small(part: Part, width: float = math.inf) -> bool:
    """Whether one table of all joint states is the fastest way, and within ``width`` bits."""
    cells = math.prod(part.cards)
    return cells <= CELLS and math.log2(cells) <= width


def solve(part: Part, clock: Clock) -> Solved:
    """(ln of the sum of a piece's weights, the belief of each of its variables); OutOfTimeError past the clock. Knows no width guard."""
    if small(part):
        return joint(part.cards, part.tables)
    return two_way(part.cards, part.tables, planned(part, clock)[1], clock.check)


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
