"""The ranking of a small graph: all its joint states in one table, sorted at once, without a look at its pieces.

Costs are whole units as in ``ranked_units``, here in doubles, which add whole numbers below 2^53 exactly, and in which impossible is +inf.
"""

from __future__ import annotations

import functools
import math
import operator
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from plogic.inference.ranked_units import DIGITS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from plogic.inference.graph import FactorGraph

STATES = 1 << 10  # joint states up to which a graph is small
FACTORS = 64  # likewise
_UNIT = -(2.0**DIGITS)
EXACT = 2.0 ** (53 - DIGITS)  # nats in all, likewise: sums of units stay exact
_CHUNK = 64  # states that are decoded together


def whole(graph: FactorGraph, tie: int) -> Iterator[tuple[float, tuple[int, ...]]] | None:
    """All joint states of positive weight with their log weights, those within ``tie`` units of the first of them by states.

    None where the graph is not small, or its weights need more digits than a double has.
    """
    cards, factors = graph.cards, graph.factors
    if not 0 < len(factors) <= FACTORS or math.prod(cards) > STATES or graph.constant == -math.inf:
        return None
    flat = np.concatenate([factor.table for factor in factors], axis=None)
    if not np.abs(flat[flat > -np.inf]).sum() < EXACT:
        return None
    return _sorted(cards, _total(graph, np.rint(flat * _UNIT)), graph.constant, tie)


def _total(graph: FactorGraph, costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """The costs of all joint states, flat; ``costs`` are those of the tables, one after the other."""
    cards = graph.cards
    terms, start = [], 0
    for factor in graph.factors:
        scope = factor.scope
        first = scope[0] if scope else len(cards)  # the axes before are left to broadcasting
        shape = [1] * (len(cards) - first)
        for v in scope:
            shape[v - first] = cards[v]
        stop = start + factor.table.size
        terms.append(costs[start:stop].reshape(shape))
        start = stop
    total = functools.reduce(operator.add, terms)
    return (total if total.shape == cards else np.broadcast_to(total, cards)).ravel()


def _sorted(cards: tuple[int, ...], costs: NDArray[np.float64], constant: float, tie: int) -> Iterator[tuple[float, tuple[int, ...]]]:
    order = costs.argsort(kind="stable")
    costs = costs[order]
    possible = int(costs.searchsorted(np.inf))
    order, costs = order[:possible], costs[:possible]
    if (costs[1:] - costs[:-1] <= tie).any():
        _level(order, costs, tie)
    strides = list(accumulate(reversed(cards[1:]), operator.mul, initial=1))[::-1]
    for start in range(0, possible, _CHUNK):
        states = (order[start : start + _CHUNK, None] // strides % cards).tolist()
        for cost, state in zip(costs[start : start + _CHUNK].tolist(), states, strict=True):
            yield constant + cost / _UNIT, tuple(state)


def _level(order: NDArray[np.intp], costs: NDArray[np.float64], tie: int) -> None:
    """Put ties in lexicographic order, in place; their costs do not fall."""
    start = 0
    while start < len(order):
        stop = int(costs.searchsorted(costs[start] + tie, side="right"))
        by_state = order[start:stop].argsort()
        order[start:stop] = order[start:stop][by_state]
        costs[start:stop] = np.maximum.accumulate(costs[start:stop][by_state])
        start = stop
