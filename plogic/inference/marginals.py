"""Exact marginals of all variables, the sum of all weights, and graphs with some variables summed out.

Every connected piece is solved apart. Tables are natural logarithms, −inf is
impossible; a belief is P(state) given that some joint state holds; variables of card 1 are certain. Where no joint
state is possible, ``log_z`` is (−inf, −inf) and every belief is NaN.

``Remembered`` gives the beliefs of a graph that changes, and solves only the connected pieces with new content. A piece
is known by its content (cards and tables, in its own numbering), not by its place: a piece that comes back, or another
one just like it, is not solved again. The answers have the bytes that ``beliefs`` gives.

A piece is solved exactly where its tables are small enough and time allows: by the table of all joint states, or by two
passes over a tree of buckets. Else it is solved case by case: the variables of a cutset are fixed, so that the rest has
small tables (J. Pearl's conditioning; loop-cutset and w-cutset of Dechter).
"""

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from plogic.base.clock import Clock, OutOfTimeError
from plogic.base.errors import WidthError
from plogic.inference.conditioning import conditioned, glanced, hasty
from plogic.inference.graph import Beliefs, Factor, FactorGraph, Part, log_sum, product, split
from plogic.inference.order import (
    BUCKET_CELLS,
    Bucket,
    Order,
    bucket_tree,
    elimination_order,
    members,
    min_fill,
    neighbours,
    order_along,
)
from plogic.inference.passes import Solved, impossible, joint, two_way

Key = tuple[tuple[int, ...], tuple[tuple[int, ...], ...], tuple[bytes, ...], float]


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
            raise WidthError(
                f"{len(part.cards)} variables hang together so closely that exact sums need tables of {order.width:.1f} bits "
                f"(the limit is {width:g}), and more than 2^{EFFORT:g} cells case by case; with a deadline (seconds) the answer is "
                f"intervals"
            )
        return conditioned(part, cut, PRUNE, clock)
    budget = _bits(clock.left() / 2)
    bits = min(width, BUCKET, max(PRUNE, budget - 14.0))
    cut = cutset(part, order, width, MOST_CUT_BITS, clock)
    if cut and not _fair(cut.work(part.cards), math.prod(part.cards[v] for v in cut.fixed) * len(cut.buckets), clock):
        cut = cutset(part, order, min(width, max(6.0, budget - 8.0)), MOST_CUT_BITS, clock) or cut
    return conditioned(part, cut, bits, clock) if cut else glanced(part, order.sequence, bits, clock)


WIDTH = 20.0  # bits: tables of 2^20 doubles are 8 MB
_CERTAIN = np.ones(1)
_CERTAIN.flags.writeable = False


def beliefs(graph: FactorGraph, *, width: float = WIDTH, seconds: float | None = None) -> Beliefs:
    """The sum of all weights and the belief of every variable.

    A connected piece whose tables would be larger than 2^``width`` cells is solved case by case. Without ``seconds``
    the answer is exact, and the same at every call. With ``seconds`` it takes about that long at most, and what is not
    finished by then is an interval that contains the exact value, however wide.

    Raises:
        WidthError: without ``seconds``, where the cases of some piece are hopelessly many.
    """
    log_z, parts = split(graph)
    return assembled(graph.cards, log_z, parts, solve_all(parts, width, Clock(seconds)))


def solve_all(parts: Sequence[Part], width: float, clock: Clock) -> list[Beliefs]:
    """Every piece solved, as far as the clock allows: the easy ones first, the others share what is left."""
    easy = {i: bounded(part, width, clock) for i, part in enumerate(parts) if small(part, width)}
    hard = [i for i in range(len(parts)) if i not in easy]
    for done, i in enumerate(hard):
        easy[i] = bounded(parts[i], width, clock.share(len(hard) - done))
    return [easy[i] for i in range(len(parts))]


def assembled(cards: Sequence[int], log_z: float, parts: Sequence[Part], solved: Sequence[Beliefs]) -> Beliefs:
    """The pieces put together; ``log_z`` is the log weight of every joint state."""
    ends = math.fsum([log_z, *(one.log_z[0] for one in solved)]), math.fsum([log_z, *(one.log_z[1] for one in solved)])
    if ends[1] == -math.inf:
        nothing = impossible(cards)
        return Beliefs(ends, nothing, nothing)
    low = [_CERTAIN] * len(cards)
    high = list(low)
    for part, one in zip(parts, solved, strict=True):
        for v, least, most in zip(part.variables, one.low, one.high, strict=True):
            low[v], high[v] = least, most
    return Beliefs(ends, tuple(low), tuple(high))


def summed_out(graph: FactorGraph, variables: Sequence[int], *, width: float = WIDTH) -> FactorGraph:
    """The graph after ``variables`` are summed out: same numbering, they keep one state.

    Each sum is a factor over its neighbours.

    Raises:
        WidthError: a sum would need a table of more than ``width`` bits.
    """
    cards = graph.cards
    gone = set(variables)
    sequence, _ = min_fill(neighbours(len(cards), [f.scope for f in graph.factors]), cards, variables)
    live: dict[int, Factor] = dict(enumerate(graph.factors))
    touching: dict[int, set[int]] = {v: set() for v in sequence}
    for number, factor in live.items():
        for v in touching.keys() & set(factor.scope):
            touching[v].add(number)
    constants = [graph.constant]
    for fresh, v in enumerate(sequence, len(live)):
        entering = [live.pop(number) for number in sorted(touching[v])]
        if not entering:
            constants.append(math.log(cards[v]))
            continue
        constant, told = _summed(entering, v, cards, width)
        constants.append(constant)
        done = touching.pop(v)
        for u in touching.keys() & {u for factor in entering for u in factor.scope}:
            touching[u] -= done
            touching[u].update([fresh] * (u in told.scope))
        if told.scope:
            live[fresh] = told
    left = tuple([1 if v in gone else card for v, card in enumerate(cards)])
    return FactorGraph(left, tuple(live.values()), math.fsum(constants))


def _summed(factors: Sequence[Factor], v: int, cards: Sequence[int], width: float) -> tuple[float, Factor]:
    """(log scale, the factor over v's neighbours) of the product of the factors summed over v; v's axis goes last."""
    scope = sorted({u for factor in factors for u in factor.scope} - {v})
    size = sum(math.log2(cards[u]) for u in (*scope, v))
    if size > width:
        raise WidthError(
            f"summing out variable {v} needs a table of {size:.1f} bits; the limit is {width:g}: raise it, or keep the variable"
        )
    top, told = log_sum(product([(factor.scope, factor.table) for factor in factors], (*scope, v), cards))
    return top, Factor(tuple(scope), told) if top > -math.inf else Factor((), np.zeros(()))


PIECES = 4096  # remembered at most; the one not asked for the longest goes first


class Remembered:
    """``beliefs`` like the function of that name; ``solved`` counts the pieces that it had to solve."""

    def __init__(self, pieces: int = PIECES) -> None:
        self.solved = 0
        self._pieces = pieces
        self._known: OrderedDict[Key, Beliefs] = OrderedDict()

    def beliefs(self, graph: FactorGraph, *, width: float = WIDTH, seconds: float | None = None) -> Beliefs:
        """See ``plogic.inference.marginals.beliefs``; an interval that a deadline left is not remembered."""
        log_z, parts = split(graph)
        keys: list[Key] = [
            (
                part.cards,
                tuple([scope for scope, _ in part.tables]),
                tuple([table.tobytes() for _, table in part.tables]),
                width,
            )
            for part in parts
        ]
        new = {key: part for key, part in zip(keys, parts, strict=True) if key not in self._known}
        fresh = dict(zip(new, solve_all(list(new.values()), width, Clock(seconds)), strict=True))
        self.solved += len(fresh)
        solved = [fresh[key] if key in fresh else self._known[key] for key in keys]
        for key in keys:
            if key in self._known:
                self._known.move_to_end(key)
            elif fresh[key].low is fresh[key].high:
                self._known[key] = fresh[key]
        while len(self._known) > self._pieces:
            self._known.popitem(last=False)
        return assembled(graph.cards, log_z, parts, solved)
