"""Every possible joint state of a factor graph, heaviest first, made as far as it is asked for.

Vocabulary, each with an example value:

* ``Ranked(graph)`` yields ``(-0.7, (0, 2, 1))``: the log weight and one state a variable
* ``Ranked(graph, seconds=0.5)``: the same with a deadline; ``.states`` so far, ``.finished`` if there are no more

What is guaranteed: every joint state of positive weight comes exactly once; the log weights never increase, and are
within 1e-9 of the sums of the tables' entries (relative, where tables span more than a million); the same graph gives
the same sequence, so the first n are the first n of any longer list. States within 1e-11 of each other are ties: of
those that follow the first of them, up to ``MOST_TIES`` are looked at together and come in lexicographic order, with
one falling weight. More ties than that come by whole units of 2.3e-13 (``ranked_tables``), and in lexicographic order
where these are equal; in a piece that is wider than ``WIDTH`` bits, in the order of the search; in a graph of few joint
states all ties are looked at together.

The joint states of a small graph are sorted at once in one table (``whole``). A cost is how many nats a state lies
below the sum of the tables' greatest entries, so that the best states' costs have the least noise.
"""

import functools
import math
import operator
from collections.abc import Iterator
from itertools import accumulate, islice

import numpy as np
from numpy.typing import NDArray

from plogic.base.clock import Clock, OutOfTimeError
from plogic.inference.graph import FactorGraph, Part, split
from plogic.inference.marginals import WIDTH, plan
from plogic.inference.merge import Stream, sums
from plogic.inference.ranked_component import component, wide
from plogic.inference.ranked_tables import DIGITS, Digits, joint

State = tuple[float, tuple[int, ...]]

STATES = 1 << 10  # joint states up to which a graph is small
FACTORS = 64  # and variables, for an array has no more axes; likewise
SPAN = 2.0**14  # nats below the best state, likewise: 64 sums of doubles of this size are exact to 8e-12
_CHUNK = 64  # states that are decoded together


def whole(graph: FactorGraph, tie: float) -> Iterator[tuple[float, tuple[int, ...]]] | None:
    """All joint states of positive weight with their log weights; within ``tie`` nats of the first ordered by states.

    None where the graph is not small, or some state lies so far below the best that its cost is not known to within
    ``tie``.
    """
    cards, factors = graph.cards, graph.factors
    small = 0 < len(factors) <= FACTORS and len(cards) <= FACTORS and math.prod(cards) <= STATES
    if not small or graph.constant == -math.inf:
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
    return _decoded_together(cards, order[:possible], costs[:possible], graph.constant + math.fsum(tops.tolist()), tie)


def _total(graph: FactorGraph, costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """The costs of all joint states, flat; ``costs`` are those of the tables, one after the other."""
    cards = graph.cards
    terms, start = [], 0
    for factor in graph.factors:
        scope, stop = factor.scope, start + factor.table.size
        first = scope[0] if scope else len(cards)  # the axes before are left to broadcasting
        shape = [1] * (len(cards) - first)
        for v in scope:
            shape[v - first] = cards[v]
        terms.append(costs[start:stop].reshape(shape))
        start = stop
    total = functools.reduce(operator.add, terms)
    return (total if total.shape == cards else np.broadcast_to(total, cards)).ravel()


def _decoded_together(
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


JOINT_CELLS = 1 << 12  # cells up to which a piece is one table
WORK = 29.0  # bits of all tables, of which about half are kept, 8 bytes each: 2 GB; likewise
TIE_NATS = 1e-11  # nats within which log weights count as equal
MOST_TIES = 256  # such states that are put in order together
_UNITS = 1 << DIGITS


class Ranked:
    """The joint states, heaviest first, with a deadline of ``seconds`` from now.

    An iterator that stops early once it has passed.

    Of the last ties before the deadline some may be missing, and others stand in their place; otherwise what came is a
    prefix.
    """

    def __init__(self, graph: FactorGraph, *, seconds: float | None = None) -> None:
        self.states: list[State] = []
        self.finished = False
        self._source = _states(graph, Clock(seconds))

    def __iter__(self) -> Iterator[State]:
        return self

    def __next__(self) -> State:
        """The next joint state; StopIteration when there is none (``finished``), or when time is out."""
        try:
            state = next(self._source)
        except OutOfTimeError:
            raise StopIteration from None
        except StopIteration:
            self.finished = True
            raise
        self.states.append(state)
        return state


def best(graph: FactorGraph, n: int) -> list[State]:
    """Return the ``n`` heaviest joint states, fewer if there are fewer.

    Raises:
        LimitError: a wide piece needs too many open nodes.
    """
    return list(islice(_states(graph, Clock(None)), n))


def _states(graph: FactorGraph, clock: Clock) -> Iterator[State]:
    return whole(graph, TIE_NATS) or _merged(graph, clock)


def _merged(graph: FactorGraph, clock: Clock) -> Iterator[State]:
    """The solutions of the pieces, merged."""
    constant, parts = split(graph)
    if constant == -math.inf:
        return
    count = len(graph.cards)
    width = (max(graph.cards, default=1) - 1).bit_length() + 7 >> 3 or 1  # bytes a state
    bits = 8 * width * count
    places = [1 << (bits - 8 * width * (v + 1)) for v in range(count)]
    pieces = [_stream(part, Digits([places[v] for v in part.variables], bits), clock) for part in parts]
    constant, mask = math.fsum([constant, *(top for top, _ in pieces)]), (1 << bits) - 1
    for solution in _tied(sums([stream for _, stream in pieces], clock), bits):
        yield constant - (solution >> bits) / _UNITS, _decoded(solution & mask, count, width)


def _stream(part: Part, digits: Digits, clock: Clock) -> tuple[float, Stream]:
    """(log weight of cost 0, the solutions of one piece)."""
    if math.prod(part.cards) <= JOINT_CELLS:
        return 0.0, joint(part, digits)
    order, buckets = plan(part.cards, tuple([scope for scope, _ in part.tables]))
    if order.width > WIDTH or order.work > WORK:  # then the heuristic is a bound
        return wide(part, order, digits, clock)
    return component(part, buckets, digits, clock)


def _decoded(code: int, count: int, width: int) -> tuple[int, ...]:
    """One state a variable, from a code with ``width`` bytes each."""
    digits = code.to_bytes(count * width, "big")
    if width == 1:
        return tuple(digits)
    return tuple([int.from_bytes(digits[i : i + width], "big") for i in range(0, len(digits), width)])


def _tied(source: Iterator[int], bits: int) -> Iterator[int]:
    """The same solutions, those that tie by code, and their costs non-decreasing."""
    tie = round(TIE_NATS * _UNITS) << bits
    group: list[int] = []
    limit = 0
    late: OutOfTimeError | None = None
    try:
        for solution in source:
            if group and solution <= limit and len(group) < MOST_TIES:
                group.append(solution)
                continue
            if len(group) > 1:
                yield from _levelled(group, bits)
            elif group:
                yield group[0]
            group = [solution]
            limit = solution + tie
    except OutOfTimeError as error:
        late = error
    yield from _levelled(group, bits)
    if late is not None:
        raise late


def _levelled(group: list[int], bits: int) -> Iterator[int]:
    mask = (1 << bits) - 1
    cost = min(group, default=0) >> bits
    for solution in sorted(group, key=mask.__and__):
        cost = max(cost, solution >> bits)
        yield cost << bits | solution & mask
