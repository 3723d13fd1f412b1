"""Exact marginals of all variables, the sum of all weights, and graphs with some variables summed out.

Every connected piece is solved apart, by two passes over a tree of buckets. Tables are natural logarithms, −inf is
impossible; a belief is P(state) given that some joint state holds; variables of card 1 are certain. Where no joint
state is possible, ``log_z`` is (−inf, −inf) and every belief is NaN.

``Remembered`` gives the beliefs of a graph that changes, and solves only the connected pieces with new content. A piece
is known by its content (cards and tables, in its own numbering), not by its place: a piece that comes back, or another
one just like it, is not solved again. The answers have the bytes that ``beliefs`` gives.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import Clock
from plogic.base.errors import WidthError
from plogic.inference.axes import log_sum, product
from plogic.inference.exact import bounded, small
from plogic.inference.graph import Beliefs, Factor, FactorGraph, split
from plogic.inference.order import min_fill, neighbours
from plogic.inference.passes import impossible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.inference.graph import Part

    Key = tuple[tuple[int, ...], tuple[tuple[int, ...], ...], tuple[bytes, ...], float]


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
        keys = [_key(part, width) for part in parts]
        new = {key: part for key, part in zip(keys, parts, strict=True) if key not in self._known}
        fresh = dict(zip(new, solve_all(list(new.values()), width, Clock(seconds)), strict=True))
        self.solved += len(fresh)
        result = assembled(
            graph.cards, log_z, parts, [fresh[key] if key in fresh else self._known[key] for key in keys]
        )
        self._remember(keys, fresh)
        return result

    def _remember(self, keys: list[Key], fresh: dict[Key, Beliefs]) -> None:
        for key in keys:
            if key in self._known:
                self._known.move_to_end(key)
            elif fresh[key].low is fresh[key].high:
                self._known[key] = fresh[key]
        while len(self._known) > self._pieces:
            self._known.popitem(last=False)


def _key(part: Part, width: float) -> Key:
    return (
        part.cards,
        tuple([scope for scope, _ in part.tables]),
        tuple([table.tobytes() for _, table in part.tables]),
        width,
    )
