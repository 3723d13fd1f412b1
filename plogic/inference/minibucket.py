"""An upper bound of the sum of all weights, by tables of bounded size (R. Dechter and I. Rish, Mini-buckets, 2003).

Where the tables that a variable is to be summed out of would make too large a product, they go in several groups: the
first is summed, the others are maximised, and Σ f·g ≤ Σ f · max g.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.inference.axes import log_sum, product

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from plogic.base.clock import Clock
    from plogic.inference.axes import Scoped


class Bound(NamedTuple):
    """``upper`` ≥ ln Σ weights; ``buckets``: per variable of the order, the tables that it was summed out of."""

    upper: float
    buckets: dict[int, list[Scoped]]


def mini_buckets(
    cards: Sequence[int], tables: Sequence[Scoped], sequence: Sequence[int], bits: float, clock: Clock
) -> Bound:
    """The bound with products of at most 2^``bits`` cells (a given table may be larger); OutOfTimeError past the clock.

    ``sequence`` has all variables of the tables, none of which is over no variable.
    """
    turn = {v: i for i, v in enumerate(sequence)}
    buckets: dict[int, list[Scoped]] = {v: [] for v in sequence}
    for scope, table in tables:
        buckets[min(scope, key=turn.__getitem__)].append((scope, table))
    terms = []
    for v in sequence:
        clock.check()
        terms += [math.log(cards[v])] * (not buckets[v])
        for number, group in enumerate(_groups(buckets[v], cards, bits)):
            scope = tuple(sorted({u for own, _ in group for u in own} - {v}, key=turn.__getitem__))
            top, told = (_maximum if number else log_sum)(product(group, (*scope, v), cards))
            terms.append(top)
            if top == -math.inf:
                return Bound(top, buckets)
            if scope:
                buckets[scope[0]].append((scope, told))
    return Bound(math.fsum(terms), buckets)


def _groups(tables: Sequence[Scoped], cards: Sequence[int], bits: float) -> list[list[Scoped]]:
    """First fit, the largest first."""
    groups: list[tuple[set[int], list[Scoped]]] = []
    for scope, table in sorted(tables, key=lambda one: -one[1].size):
        for union, group in groups:
            if sum(math.log2(cards[v]) for v in union.union(scope)) <= bits:
                union.update(scope)
                group.append((scope, table))
                break
        else:
            groups.append((set(scope), [(scope, table)]))
    return [group for _, group in groups]


def _maximum(table: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    best = table.max(axis=-1)
    top = float(best.max())
    return (top, best - top) if top > -math.inf else (top, np.zeros(best.shape))


def promising(cards: Sequence[int], bound: Bound) -> dict[int, int]:
    """A joint state that should weigh much: backwards through the buckets, each variable's best state given those already chosen."""
    states: dict[int, int] = {}
    for v in reversed(list(bound.buckets)):
        table = np.zeros(cards[v])
        for scope, own in bound.buckets[v]:
            table += own[tuple([states.get(u, slice(None)) for u in scope])]
        states[v] = int(table.argmax())
    return states


def log_weight(tables: Sequence[Scoped], states: Mapping[int, int]) -> float:
    """The log weight of one joint state."""
    return math.fsum(float(table[tuple([states[v] for v in scope])]) for scope, table in tables)
