"""Answers by a deadline: exact if they are counted in time, else the intervals that are known by then.

The counting is done in a thread; meanwhile the bounds are refined, and told more and more rarely. ``Bounds`` contain
P(query | evidence) at any time, and shrink while alternatives are decided best first. A partial decision is evaluated
in three values, many decisions at once (``Truth``). It settles its mass where the query and the evidence hold, the
query fails under the evidence, or the evidence fails; else its mass is open. From the masses that are certain, and
those that are possible, follows the interval; rounding widens it.
"""

import heapq
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plogic.logic.answers.answer import grouped
from plogic.logic.answers.ways import probabilities
from plogic.logic.grounding.ground_program import TRUE, Ground
from plogic.logic.grounding.load import ground, request_from

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]
UNDECIDED = -1
"""An alternative that is not decided yet."""


@dataclass(frozen=True)
class _Level:
    """Gates of one kind: ``gates`` are variables, children of the i-th start at ``first[i]`` in ``children``."""

    conjunction: bool
    gates: Ints
    children: Ints
    first: Ints


@dataclass(frozen=True)
class Truth:
    """``owner[v]``, ``outcome[v]``: the alternative whose outcome the variable is, −1 where it is none."""

    size: int
    owner: Ints
    outcome: Ints
    constants: tuple[int, ...]
    levels: tuple[_Level, ...]

    def certain(self, decided: Ints) -> Bools:
        """``certain[literal, column]``: the literal holds whatever the open alternatives come to.

        ``(2 size + 1, columns)``.

        ``decided``: outcome of each alternative, or UNDECIDED, ``(alternatives, columns)``. Negative literals count
        from the end.
        """
        certain = np.zeros((2 * self.size + 1, decided.shape[1]), dtype=bool)
        certain[0] = True
        choices = np.flatnonzero(self.owner >= 0)
        came = decided[self.owner[choices]]
        certain[choices] = came == self.outcome[choices, np.newaxis]
        certain[-choices] = (came != UNDECIDED) & (came != self.outcome[choices, np.newaxis])
        certain[list(self.constants)] = True
        for level in self.levels:
            every, some = (level.gates, -level.gates) if level.conjunction else (-level.gates, level.gates)
            sign = 1 if level.conjunction else -1
            certain[every] = np.logical_and.reduceat(certain[sign * level.children], level.first, axis=0)
            certain[some] = np.logical_or.reduceat(certain[-sign * level.children], level.first, axis=0)
        return certain


def truth_of(ground: Ground) -> Truth:
    """The ground program, its gates in levels above their children."""
    owner = np.full(ground.size + 1, -1, dtype=np.int64)
    outcome = np.full(ground.size + 1, -1, dtype=np.int64)
    for i, alternative in enumerate(ground.alternatives):
        owner[list(alternative.variables)] = i
        outcome[list(alternative.variables)] = range(len(alternative.variables))
    depth = [0] * (ground.size + 1)
    groups: dict[tuple[int, bool], list[tuple[int, tuple[int, ...]]]] = {}
    constants = []
    for variable, gate in ground.gates.items():
        children = gate.folded()
        if not isinstance(children, tuple):
            constants.append(-variable if children is None else variable)
            continue
        depth[variable] = 1 + max(depth[abs(child)] for child in children)
        groups.setdefault((depth[variable], gate.kind == "and"), []).append((variable, children))
    levels = tuple(_level(conjunction, groups[level, conjunction]) for level, conjunction in sorted(groups))
    return Truth(ground.size, owner, outcome, tuple(constants), levels)


def _level(conjunction: bool, gates: list[tuple[int, tuple[int, ...]]]) -> _Level:  # noqa: FBT001 - a kind of gate
    counts = [len(children) for _, children in gates]
    flat = np.fromiter((child for _, children in gates for child in children), dtype=np.int64)
    first = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)
    return _Level(conjunction, np.array([variable for variable, _ in gates], dtype=np.int64), flat, first)


def columns(vectors: Iterable[tuple[int, ...]], alternatives: int) -> Ints:
    """Partial decisions, prefixes of the alternatives, as columns."""
    prefixes = list(vectors)
    decided = np.full((alternatives, len(prefixes)), UNDECIDED, dtype=np.int64)
    for column, prefix in enumerate(prefixes):
        decided[: len(prefix), column] = prefix
    return decided


DECISIONS_AT_ONCE = 64
"""Partial decisions that are taken further together."""
MOST_OPEN = 200_000
"""Partial decisions that may be open: more would not fit into memory, so the bounds stay as they are."""
ADDITION_ERROR = 2.0**-52
"""What one addition of masses can be wrong by, at most."""


@dataclass(order=True)
class _Open:
    """A partial decision whose mass is not settled.

    Of each query, with the evidence: whether it certainly, and possibly, holds or fails.
    """

    minus_mass: float
    order: int
    decided: tuple[int, ...] = field(compare=False)
    certain: Bools = field(compare=False)
    possible: Bools = field(compare=False)


class Bounds:
    """``intervals`` at any time; ``refine`` takes the most probable open decisions further, until ``done``.

    ``certain``, ``possible``: masses of (query holds and evidence, query fails and evidence), ``(2, queries)``;
    ``sums``: additions so far.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self.truth = truth_of(ground)
        self.observed = np.array(ground.observed, dtype=np.int64)
        self.queries = [literal for _, literal in ground.asked]
        self.outcomes = [[*alternative.shares, alternative.rest] for alternative in ground.alternatives]
        self.certain = np.zeros((2, len(self.queries)))
        self.possible = np.zeros((2, len(self.queries)))
        self.sums = 0
        self.open: list[_Open] = []
        self._add([((), 1.0)])

    @property
    def done(self) -> bool:
        """Nothing is open, or there is no room for more."""
        return not self.open or len(self.open) > MOST_OPEN

    def refine(self) -> None:
        """Decide one more alternative in each of the most probable open decisions."""
        children: list[tuple[tuple[int, ...], float]] = []
        for _ in range(min(DECISIONS_AT_ONCE, len(self.open))):
            item = heapq.heappop(self.open)
            self._count(item.minus_mass, item.certain, item.possible)
            shares = self.outcomes[len(item.decided)]
            children += [((*item.decided, i), -item.minus_mass * share) for i, share in enumerate(shares) if share > 0]
        self._add(children)

    def intervals(self) -> list[tuple[float, float]]:
        """Of each query, an interval that contains its probability given the evidence.

        [0, 1] where the evidence may be impossible.
        """
        slack = (self.sums + 1) * ADDITION_ERROR
        least, most = np.maximum(self.certain - slack, 0.0), np.minimum(self.possible + slack, 1.0)
        with np.errstate(invalid="ignore"):
            low = np.where(least[0] > 0, least[0] / (least[0] + most[1]) - ADDITION_ERROR, 0.0)
            high = np.where(least[1] > 0, most[0] / (most[0] + least[1]) + ADDITION_ERROR, 1.0)
        return [(max(float(a), 0.0), min(float(b), 1.0)) for a, b in zip(low, high, strict=True)]

    def _add(self, decisions: list[tuple[tuple[int, ...], float]]) -> None:
        """Count the decisions.

        Those that leave something open are kept, those that the evidence excludes are not counted.
        """
        certain = self.truth.certain(columns((decided for decided, _ in decisions), len(self.outcomes)))
        holds = np.asarray(certain[self.observed].all(axis=0))
        fails = np.asarray(certain[-self.observed].any(axis=0))
        yes, no = self._queries(certain)
        for column, (decided, mass) in enumerate(decisions):
            if fails[column]:
                continue
            settled = np.stack((yes[:, column], no[:, column])) & holds[column]
            possible = ~np.stack((no[:, column], yes[:, column]))
            self._count(mass, settled, possible)
            if len(decided) < len(self.outcomes) and not (settled == possible).all():
                heapq.heappush(self.open, _Open(-mass, self.sums, decided, settled, possible))

    def _count(self, mass: float, certain: Bools, possible: Bools) -> None:
        self.certain += mass * certain
        self.possible += mass * possible
        self.sums += 1

    def _queries(self, certain: Bools) -> tuple[Bools, Bools]:
        """Whether each certainly holds, or fails, ``(queries, columns)``."""
        never = np.zeros(certain.shape[1], dtype=bool)
        sides = [
            (never, ~never) if q is None else (~never, never) if q == TRUE else (certain[q], certain[-q])
            for q in self.queries
        ]
        both = np.array(sides, dtype=bool).reshape(len(sides), 2, certain.shape[1])
        return both[:, 0], both[:, 1]


FIRST_WAIT = 0.02
"""Seconds until intervals are told for the first time after those that follow from the ground program alone."""


def answers_by(document: dict[str, Any], tell: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """The exact reply to a request.

    ``tell`` gets replies with intervals on the way: ``{"answers": [[[goal, low, high], ...]], "partial"}``.

    A goal whose substitutions are not known yet is not told.
    """
    request = request_from(document)
    found = ground(request)

    def partly(intervals: list[tuple[float, float]]) -> None:
        tell(
            {
                "answers": [[[goal, *pair] for goal, pair in goals] for goals in grouped(request, found, intervals)],
                "partial": True,
            }
        )

    partly([(0.0, 1.0)] * len(found.asked))
    values = _meanwhile(found, partly)
    return {"answers": [[[goal, p] for goal, p in goals] for goals in grouped(request, found, values)]}


def _meanwhile(found: Ground, partly: Callable[[list[tuple[float, float]]], None]) -> list[float]:
    counting = ThreadPoolExecutor(1).submit(probabilities, found)
    bounds, wait, last = Bounds(found), FIRST_WAIT, time.monotonic()
    while not counting.done() and not bounds.done:
        bounds.refine()
        if time.monotonic() - last > wait:
            partly(bounds.intervals())
            wait, last = wait * 1.3, time.monotonic()
    if not counting.done():
        partly(bounds.intervals())
    return counting.result()
