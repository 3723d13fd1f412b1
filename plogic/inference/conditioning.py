"""The sum and beliefs of a piece with too large tables, case by case.

When the time is over, intervals that the cases so far prove.

The states of a cutset are tried by a best-first search. Each node fixes the first few variables of the cutset and knows
an upper bound of its mass (mini-buckets); each leaf fixes all, and is solved exactly. With Z and B the masses found
(all, and with v = s), U the sum of the bounds of the open nodes where v = s is possible, and V of those where v ≠ s is,
the exact value lies in

    B / (Z + V)  ≤  P(v = s)  ≤  (B + U) / (Z + U),        Z  ≤  Σ weights  ≤  Z + Σ bounds,

for what is open adds b ≤ U to B and o ≤ V besides, and (B + b) / (Z + b + o) grows with b and falls with o. No open
node: exact.

Mini-buckets (R. Dechter and I. Rish, 2003) bound the sum of all weights from above by tables of bounded size. Where the
tables over one variable would make too large a product, they go in several groups: the first is summed, the others are
maximised, and Σ f·g ≤ Σ f · max g.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.clock import Clock, OutOfTimeError
from plogic.inference.graph import Beliefs, in_groups, log_sum, product, sliced
from plogic.inference.passes import impossible, two_way

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from plogic.inference.graph import Part, Scoped
    from plogic.inference.marginals import Cutset

    Arrays = tuple[NDArray[np.float64], ...]
    Node = tuple[float, tuple[int, ...]]  # −bound, states of the first variables of the cutset


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
        for number, group in enumerate(in_groups(buckets[v], cards, bits)):
            scope = tuple(sorted({u for own, _ in group for u in own} - {v}, key=turn.__getitem__))
            top, told = (_maximum if number else log_sum)(product(group, (*scope, v), cards))
            terms.append(top)
            if top == -math.inf:
                return Bound(top, buckets)
            if scope:
                buckets[scope[0]].append((scope, told))
    return Bound(math.fsum(terms), buckets)


def _maximum(table: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    best = table.max(axis=-1)
    top = float(best.max())
    return (top, best - top) if top > -math.inf else (top, np.zeros(best.shape))


def promising(cards: Sequence[int], bound: Bound) -> dict[int, int]:
    """A joint state that should weigh much.

    Backwards through the buckets, each variable's best state given those already chosen.
    """
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


SUM_SLACK = 1e-12  # relative; more than the roundings of the sums, so that an interval contains the exact value and not just almost
LOG_ROUNDING = 1e-14  # of a logarithm, relative


@dataclass
class _Found:
    """Masses so far, times e^−``scale``: ``mass`` of all, ``states`` of each state of each variable."""

    cards: tuple[int, ...]
    scale: float = -math.inf
    mass: float = 0.0
    states: list[NDArray[np.float64]] = field(default_factory=list)

    def add(self, log_z: float, beliefs: list[NDArray[np.float64]]) -> None:
        """One more case."""
        if not self.states:
            self.states = [np.zeros(card) for card in self.cards]
        top = max(self.scale, log_z)
        old, new = math.exp(self.scale - top), math.exp(log_z - top)
        self.mass = self.mass * old + new
        self.states = [so_far * old + belief * new for so_far, belief in zip(self.states, beliefs, strict=True)]
        self.scale = top


def conditioned(part: Part, cut: Cutset, bits: float, clock: Clock) -> Beliefs:
    """The sum and beliefs of a piece by the cases of a cutset, bounded by mini-buckets of ``bits``.

    An interval if the clock stops it.
    """
    search = _Search(part, cut, bits, clock)
    try:
        search.run()
    except OutOfTimeError:
        return search.interval()
    return search.exact()


class _Search:
    def __init__(self, part: Part, cut: Cutset, bits: float, clock: Clock) -> None:
        self.part, self.cut, self.bits, self.clock = part, cut, bits, clock
        self.found = _Found(part.cards)
        self.known, upper = _trivial(part)  # known: the log weight of some joint state
        self.open: list[Node] = []
        self.node: Node | None = (-upper, ())

    def run(self) -> None:
        """Until no node is open: down to a leaf by the best child, then on from the best open node."""
        self.look()
        while self.node or self.open:
            self.node = self.node or heapq.heappop(self.open)
            states = self.node[1]
            if len(states) == len(self.cut.fixed):
                self.leaf(states)
                self.node = None
            else:
                fresh = sorted(self.children(states))
                self.node = fresh[0] if fresh else None
                for child in fresh[1:]:
                    heapq.heappush(self.open, child)

    def look(self) -> None:
        """A first bound, and a promising joint state."""
        self.known, upper = _glance(self.part, self.cut.order.sequence, self.bits, self.clock)
        self.node = (-upper, ()) if upper > -math.inf else None

    def children(self, node: tuple[int, ...]) -> list[Node]:
        """The possible nodes that fix one variable more."""
        result = []
        for state in range(self.part.cards[self.cut.fixed[len(node)]]):
            child = (*node, state)
            constant, tables = self.restricted(child)
            if constant > -math.inf:
                cards = self.part.cards
                fixed = set(self.cut.fixed[: len(child)])
                sequence = [v for v in self.cut.order.sequence if v not in fixed]
                bound = constant + mini_buckets(cards, tables, sequence, self.bits, self.clock).upper
                if bound > -math.inf:
                    result.append((-bound, child))
        return result

    def leaf(self, node: tuple[int, ...]) -> None:
        """Adds one case to what was found."""
        constant, tables = self.restricted(node)
        if constant > -math.inf:
            log_z, beliefs = two_way(self.cut.cards, tables, self.cut.buckets, self.clock.check)
            if log_z > -math.inf:
                whole = list(beliefs)
                for v, state in zip(self.cut.fixed, node, strict=True):
                    whole[v] = np.zeros(self.part.cards[v])
                    whole[v][state] = 1.0
                self.found.add(constant + log_z, whole)

    def restricted(self, node: tuple[int, ...]) -> tuple[float, tuple[Scoped, ...]]:
        """(log weight of what is settled, tables of the others) where the first variables of the cutset are fixed."""
        self.clock.check()
        fixed = dict(zip(self.cut.fixed, node, strict=False))
        told = [sliced(scope, table, fixed) for scope, table in self.part.tables]
        return math.fsum(float(table) for scope, table in told if not scope), tuple([one for one in told if one[0]])

    def exact(self) -> Beliefs:
        """All cases."""
        found = self.found
        if not found.mass:
            nothing = impossible(self.part.cards)
            return Beliefs((-math.inf, -math.inf), nothing, nothing)
        log_z = found.scale + math.log(found.mass)
        beliefs = tuple([states / states.sum() for states in found.states])
        return Beliefs((log_z, log_z), beliefs, beliefs)

    def interval(self) -> Beliefs:
        """What the cases so far and the bounds of the open ones prove, rounded outwards."""
        found = self.found
        nodes = [*self.open, self.node] if self.node else self.open
        top = max([found.scale, *(-bound for bound, _ in nodes)])
        if top == -math.inf:
            return self.exact()
        done = found.mass * math.exp(found.scale - top)
        rest = math.fsum(math.exp(-bound - top) for bound, _ in nodes)
        log_z = (max(top + math.log(done), self.known) if done else self.known), top + math.log(done + rest)
        if not done:
            return Beliefs(_outwards(log_z), *_unknown(self.part.cards))
        states = [array * math.exp(found.scale - top) for array in found.states]
        weighed = [(math.exp(-bound - top), node) for bound, node in nodes]
        return Beliefs(_outwards(log_z), *self.beliefs(states, done, weighed, SUM_SLACK + LOG_ROUNDING * abs(top)))

    def beliefs(
        self, states: list[NDArray[np.float64]], done: float, nodes: list[Node], slack: float
    ) -> tuple[Arrays, Arrays]:
        """(low, high) from B, Z, and the open nodes with their bounds, ``slack`` wider."""
        rest = math.fsum(bound for bound, _ in nodes)
        low, high = [], []
        place = {v: i for i, v in enumerate(self.cut.fixed)}
        for v, found in enumerate(states):
            inside = np.full(len(found), rest)
            outside = inside
            if v in place:
                inside, outside = _open_by_state(nodes, place[v], len(found))
            low.append(np.clip(found / (done + outside) * (1 - slack), 0.0, 1.0))
            high.append(np.clip((found + inside) / (done + inside) * (1 + slack), 0.0, 1.0))
        return tuple(low), tuple(high)


def _open_by_state(nodes: list[Node], place: int, card: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(U, V): bounds of open nodes where a state, or another one, of a variable of the cutset is possible."""
    settled, free = np.zeros(card), 0.0
    for bound, states in nodes:
        if len(states) > place:
            settled[states[place]] += bound
        else:
            free += bound
    return settled + free, np.array([settled[:s].sum() + settled[s + 1 :].sum() for s in range(card)]) + free


def glanced(part: Part, sequence: Sequence[int], bits: float, clock: Clock) -> Beliefs:
    """What one look by mini-buckets proves: nothing of the beliefs, unless that nothing is possible."""
    return _vague(part, _glance(part, sequence, bits, clock))


def hasty(part: Part) -> Beliefs:
    """What a look at each table proves."""
    return _vague(part, _trivial(part))


def _vague(part: Part, log_z: tuple[float, float]) -> Beliefs:
    if log_z[1] == -math.inf:
        nothing = impossible(part.cards)
        return Beliefs(log_z, nothing, nothing)
    return Beliefs(_outwards(log_z), *_unknown(part.cards))


def _glance(part: Part, sequence: Sequence[int], bits: float, clock: Clock) -> tuple[float, float]:
    """An interval of ln Σ weights by mini-buckets and a promising joint state, no wider than the trivial one."""
    bound = mini_buckets(part.cards, part.tables, sequence, bits, clock)
    if bound.upper == -math.inf:
        return bound.upper, bound.upper
    lower, upper = _trivial(part)
    return max(lower, log_weight(part.tables, promising(part.cards, bound))), min(upper, bound.upper)


def _outwards(log_z: tuple[float, float]) -> tuple[float, float]:
    """The interval a few roundings wider."""
    return log_z[0] - SUM_SLACK * (1 + abs(log_z[0])), log_z[1] + SUM_SLACK * (1 + abs(log_z[1]))


def _unknown(cards: tuple[int, ...]) -> tuple[Arrays, Arrays]:
    """Beliefs between 0 and 1."""
    return tuple([np.zeros(card) for card in cards]), tuple([np.ones(card) for card in cards])


def _trivial(part: Part) -> tuple[float, float]:
    """An interval of ln Σ weights: the joint state of zeros, and all joint states at every table's greatest."""
    lower = math.fsum(float(table[(0,) * table.ndim]) for _, table in part.tables)
    return lower, math.fsum(float(table.max()) for _, table in part.tables) + math.fsum(
        math.log(card) for card in part.cards
    )
