"""Every possible joint state of a factor graph, heaviest first, made as far as it is asked for.

Vocabulary, each with an example value:

* ``ranked(graph)`` yields ``(-0.7, (0, 2, 1))``: the log weight and one state a variable
* ``Ranked(graph, seconds=0.5)``: the same with a deadline; ``.states`` so far, ``.finished`` if there are no more

What is guaranteed: every joint state of positive weight comes exactly once; the log weights never increase, and are
within 1e-9 of the sums of the tables' entries (relative, where tables span more than a million); the same graph gives
the same sequence, so the first n are the first n of any longer list. States within 1e-11 of each other are ties: of
those that follow the first of them, up to ``AHEAD`` are looked at together and come in lexicographic order, with one
falling weight. More ties than that come by whole units of 2.3e-13 (``ranked_units``), and in lexicographic order where
these are equal; in a piece that is wider than ``WIDTH`` bits, in the order of the search; in a graph of few joint
states (``ranked_whole``) all ties are looked at together.
"""

from __future__ import annotations

import math
from itertools import islice
from typing import TYPE_CHECKING

from plogic.base.clock import Clock, OutOfTimeError
from plogic.inference.exact import plan
from plogic.inference.marginals import WIDTH
from plogic.inference.merge import sums
from plogic.inference.parts import split
from plogic.inference.ranked_component import component
from plogic.inference.ranked_joint import Digits, joint
from plogic.inference.ranked_units import DIGITS
from plogic.inference.ranked_whole import whole
from plogic.inference.ranked_wide import wide

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.inference.graph import FactorGraph
    from plogic.inference.merge import Stream
    from plogic.inference.parts import Part

    State = tuple[float, tuple[int, ...]]

JOINT = 1 << 12  # cells up to which a piece is one table
WORK = 29.0  # bits of all tables, of which about half are kept, 8 bytes each: 2 GB; likewise
TIE = 1e-11  # nats within which log weights count as equal
AHEAD = 256  # such states that are put in order together
_UNITS = 1 << DIGITS


class Ranked:
    """The joint states, heaviest first, with a deadline of ``seconds`` from now: an iterator that stops early once it has passed.

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


def ranked(graph: FactorGraph) -> Iterator[State]:
    """All joint states of positive weight, log weight non-increasing; LimitError where a wide piece needs too many open nodes."""
    return _states(graph, Clock(None))


def best(graph: FactorGraph, n: int) -> list[State]:
    """The first ``n`` of ``ranked``, fewer if there are fewer."""
    return list(islice(ranked(graph), n))


def _states(graph: FactorGraph, clock: Clock) -> Iterator[State]:
    return whole(graph, TIE) or _merged(graph, clock)


def _merged(graph: FactorGraph, clock: Clock) -> Iterator[State]:
    """The solutions of the pieces, merged."""
    constant, parts = split(graph)
    if constant == -math.inf:
        return
    count = len(graph.cards)
    width = (max(graph.cards, default=1) - 1).bit_length() + 7 >> 3 or 1  # bytes a state
    bits = 8 * width * count
    places = [1 << (bits - 8 * width * (v + 1)) for v in range(count)]
    tops, streams = [constant], []
    for part in parts:
        top, stream = _stream(part, Digits([places[v] for v in part.variables], bits), clock)
        tops.append(top)
        streams.append(stream)
    constant, mask = math.fsum(tops), (1 << bits) - 1
    for solution in _tied(sums(streams, clock), bits):
        yield constant - (solution >> bits) / _UNITS, _decoded(solution & mask, count, width)


def _stream(part: Part, digits: Digits, clock: Clock) -> tuple[float, Stream]:
    """(log weight of cost 0, the solutions of one piece)."""
    if math.prod(part.cards) <= JOINT:
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
    tie = round(TIE * _UNITS) << bits
    group: list[int] = []
    limit = 0
    late: OutOfTimeError | None = None
    try:
        for solution in source:
            if group and solution <= limit and len(group) < AHEAD:
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
