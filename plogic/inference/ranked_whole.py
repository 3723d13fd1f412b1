"""The ranking of a small graph: all its joint states in one table, sorted at once, without a look at its pieces.

A cost is how many nats a state lies below the sum of the tables' greatest entries, so that the best states' costs have
the least noise.
"""

from __future__ import annotations

import functools
import math
import operator
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from plogic.inference.graph import FactorGraph

STATES = 1 << 10  # joint states up to which a graph is small
FACTORS = 64  # likewise
SPAN = 2.0**14  # nats below the best state, likewise: 64 sums of doubles of this size are exact to 8e-12
_CHUNK = 64  # states that are decoded together


def whole(graph: FactorGraph, tie: float) -> Iterator[tuple[float, tuple[int, ...]]] | None:
    """All joint states of positive weight with their log weights, those within ``tie`` nats of the first of them by states.

    None where the graph is not small, or some state lies so far below the best that its cost is not known to within
    ``tie``.
    """
    cards, factors = graph.cards, graph.factors
    if not 0 < len(factors) <= FACTORS or math.prod(cards) > STATES or graph.constant == -math.inf:
        return None
    flat = np.concatenate([factor.table for factor in factors], axis=None)
    sizes = [factor.table.size for factor in factors]
    tops = np.maximum.reduceat(flat, list(accumulate(sizes[:-1], initial=0)))
    if tops.min() == -np.inf:
        return iter(())
    costs = _total(graph, tops.repeat(sizes) - flat)
    order = costs.argsort(kind="stable")
    costs = costs[order]
    possible = int(costs.searchsorted(np.inf))
    if possible and costs[possible - 1] > SPAN:
        return None
    return _decoded(cards, order[:possible], costs[:possible], graph.constant + math.fsum(tops.tolist()), tie)


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


def _decoded(
    cards: tuple[int, ...], order: NDArray[np.intp], costs: NDArray[np.float64], top: float, tie: float
) -> Iterator[tuple[float, tuple[int, ...]]]:
    if (costs[1:] - costs[:-1] <= tie).any():
        _level(order, costs, tie)
    strides = list(accumulate(reversed(cards[1:]), operator.mul, initial=1))[::-1]
    for start in range(0, len(order), _CHUNK):
        states = (order[start : start + _CHUNK, None] // strides % cards).tolist()
        for cost, state in zip(costs[start : start + _CHUNK].tolist(), states, strict=True):
            yield top - cost, tuple(state)


def _level(order: NDArray[np.intp], costs: NDArray[np.float64], tie: float) -> None:
    """Put ties in lexicographic order, in place; their costs do not fall."""
    start = 0
    while start < len(order):
        stop = int(costs.searchsorted(costs[start] + tie, side="right"))
        by_state = order[start:stop].argsort()
        order[start:stop] = order[start:stop][by_state]
        costs[start:stop] = np.maximum.accumulate(costs[start:stop][by_state])
        start = stop
