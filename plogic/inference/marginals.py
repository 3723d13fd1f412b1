"""Exact marginals of all variables and the sum of all weights, by two passes over a tree of buckets.

Every connected piece is solved apart. Conventions: tables are natural logarithms, −inf is impossible; a belief is
P(state) given that some joint state holds; variables of card 1 are certain. Where no joint state is possible, ``log_z``
is (−inf, −inf) and every belief is NaN.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import Clock
from plogic.inference.bounded import bounded
from plogic.inference.exact import small
from plogic.inference.parts import split
from plogic.inference.passes import impossible
from plogic.inference.sums import eliminated

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from plogic.inference.conditioning import Interval
    from plogic.inference.graph import FactorGraph
    from plogic.inference.parts import Part

WIDTH = 20.0  # bits: tables of 2^20 doubles are 8 MB
_CERTAIN = np.ones(1)
_CERTAIN.flags.writeable = False


@dataclass(frozen=True)
class Beliefs:
    """``log_z``: interval of ln Σ weights; ``low``, ``high``: per variable, shape ``(card,)``, interval of P(state); no copies where exact."""

    log_z: tuple[float, float]
    low: tuple[NDArray[np.float64], ...]
    high: tuple[NDArray[np.float64], ...]

    @property
    def exact(self) -> bool:
        """Whether every interval is one number."""
        return self.log_z[0] == self.log_z[1] and all(a is b for a, b in zip(self.low, self.high, strict=True))


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


def solve_all(parts: Sequence[Part], width: float, clock: Clock) -> list[Interval]:
    """Every piece solved, as far as the clock allows: the easy ones first, the others share what is left."""
    easy = {i: bounded(part, width, clock) for i, part in enumerate(parts) if small(part, width)}
    hard = [i for i in range(len(parts)) if i not in easy]
    for done, i in enumerate(hard):
        easy[i] = bounded(parts[i], width, clock.share(len(hard) - done))
    return [easy[i] for i in range(len(parts))]


def assembled(cards: Sequence[int], log_z: float, parts: Sequence[Part], solved: Sequence[Interval]) -> Beliefs:
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


def summed_out(graph: FactorGraph, variables: Iterable[int], *, width: float = WIDTH) -> FactorGraph:
    """The graph after ``variables`` are summed out: same numbering, they keep one state; each sum is a factor over its neighbours.

    Raises:
        WidthError: a sum would need a table of more than ``width`` bits.
    """
    return eliminated(graph, tuple(variables), width)
