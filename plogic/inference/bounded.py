"""How a connected piece is solved: exactly where its tables are small enough and the time allows it, else case by case."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING

from plogic.base.clock import OutOfTimeError
from plogic.base.errors import WidthError
from plogic.inference.conditioning import Interval, conditioned, glanced, hasty
from plogic.inference.cutset import cutset
from plogic.inference.exact import planned, small, solve
from plogic.inference.passes import two_way

if TYPE_CHECKING:
    from plogic.base.clock import Clock
    from plogic.inference.order import Order
    from plogic.inference.parts import Part
    from plogic.inference.passes import Solved

EFFORT = 32.0  # bits: cells of all cases together that are still solved without a deadline; about a minute
PACE = 1 << 26  # cells a second, a guess; only what to try before a deadline depends on it, no result
EACH = 2e-4  # seconds that a bucket takes besides; likewise
ATTEMPT = 0.75  # share of the time that is left in which an exact attempt should end, and after which it is given up
PRUNE = 5.0  # bits of the tables that see that a case is impossible
DEEP = 64.0  # bits of fixed variables; more cases than that are not begun
BUCKET = 14.0  # bits, at most, of those that bound the cases not looked at


def bounded(part: Part, width: float, clock: Clock) -> Interval:
    """A piece, exactly or (only with a limit of time) as an interval; WidthError where it is hopeless without one."""
    try:
        clock.check()
        if small(part, width):
            return _one(solve(part, clock))
        order, buckets = planned(part, clock)
        if order.width <= width and _fair(order.work, len(buckets), clock):
            with suppress(OutOfTimeError):
                return _one(two_way(part.cards, part.tables, buckets, clock.some(ATTEMPT).check))
        return _cases(part, order, width, clock)
    except OutOfTimeError:
        return hasty(part)


def _fair(work: float, buckets: float, clock: Clock) -> bool:
    """Whether tables of 2^``work`` cells in so many buckets should be done in time."""
    return clock.end is None or work <= _bits(ATTEMPT * clock.left() - buckets * EACH)


def _bits(seconds: float) -> float:
    """log2 of the cells that a time allows."""
    return math.log2(max(seconds * PACE, 1.0))


def _one(solved: Solved) -> Interval:
    log_z, beliefs = solved
    return Interval((log_z, log_z), beliefs, beliefs)


def _cases(part: Part, order: Order, width: float, clock: Clock) -> Interval:
    if clock.end is None:
        cut = cutset(part, order, width, EFFORT, clock)
        if cut is None or cut.work(part.cards) > EFFORT:
            raise WidthError(_hopeless(part, order, width))
        return conditioned(part, cut, PRUNE, clock)
    budget = _bits(clock.left() / 2)
    bits = min(width, BUCKET, max(PRUNE, budget - 14.0))
    cut = cutset(part, order, width, DEEP, clock)
    if cut and not _fair(cut.work(part.cards), math.prod(part.cards[v] for v in cut.fixed) * len(cut.buckets), clock):
        cut = cutset(part, order, min(width, max(6.0, budget - 8.0)), DEEP, clock) or cut
    return conditioned(part, cut, bits, clock) if cut else glanced(part, order.sequence, bits, clock)


def _hopeless(part: Part, order: Order, width: float) -> str:
    return (
        f"{len(part.cards)} variables hang together so closely that exact sums need tables of {order.width:.1f} bits "
        f"(the limit is {width:g}), and more than 2^{EFFORT:g} cells case by case; with a deadline (seconds) the answer is intervals"
    )
