"""A factor graph under construction: the variables of a scene, and log weights accumulated by scope.

One variable is the alternative of the rivals of one instance (§8). Vocabulary, each with an example value:

* ``Alternative((None, "h1", "h4"))``: state 0 is that none of them is present, state i that the i-th is, and no other
* ``Cast.place["h4"] == (0, 2)``: h4 is present where variable 0 is in state 2
* a *literal* ``(3, (1, 2))``: variable 3 is in one of these states
* a *bit table* over n literals: an array (2^n,) whose row r is for the joint truth values of which the i-th is bit i
  of r
"""

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from geometry.arrays import Floats
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.situation import Situation
from plogic.inference import gates
from plogic.inference.gates import Formula, observed, with_formulas
from plogic.inference.graph import Factor, FactorGraph

Literal: TypeAlias = tuple[int, tuple[int, ...]]
"""A variable, and the states of which it is in one."""


class Choice(NamedTuple):
    """The variable of a choice beside presence, and what its states say.

    Of an appearance's cause ``(("noise",), ("h1", "roof/apex"), ...)``, in the order of Δh.
    """

    variable: int
    states: tuple[tuple[str, ...], ...]

    def literal(self, *said: str) -> gates.Literal:
        """The variable is in the state that says it."""
        return gates.Literal(self.variable, frozenset({self.states.index(said)}))


@dataclass(frozen=True)
class Alternative:
    """``states[0]`` is None, for none of them; ``states[i]`` the id of the hypothesis that is present."""

    states: tuple[str | None, ...]


@dataclass(frozen=True)
class Cast:
    """A situation with the variables of its graph and its look-ups.

    ``unhiding["h4"]``: h4 and its rivals, none of which hides h4 (§4.1).
    """

    situation: Situation
    variables: tuple[Alternative, ...]
    place: dict[str, tuple[int, int]]
    opaque: frozenset[str]
    unhiding: dict[str, set[str]]

    def hiders(self, h: Hypothesis, f: FeatureFact) -> list[str]:
        """The hypotheses that hide the feature in every world in which they are present (D4, D7), each once."""
        opaque, unhiding = self.opaque, self.unhiding[h.id]
        found = [g for g in f.hidden_by if g in opaque and g not in unhiding]
        return found if len(found) < 2 else list(dict.fromkeys(found))

    def literals(self, names: Iterable[str]) -> list[Literal]:
        """One literal a variable: one of ``names`` is present; by variable."""
        states: dict[int, list[int]] = {}
        for name in names:
            variable, state = self.place[name]
            states.setdefault(variable, []).append(state)
        return [(variable, tuple(sorted(states[variable]))) for variable in sorted(states)]


def cast_of(situation: Situation) -> Cast:
    """The variables, in the order of Δh of their first members, with the look-ups."""
    units = _groups(situation) if situation.reading == "posterior" else _cliques(situation)
    variables = tuple([Alternative((None, *members)) for members in units])
    place = {name: (v, s) for v, members in enumerate(units) for s, name in enumerate(members, 1)}
    unhiding = {h.id: {h.id} for h in situation.hypotheses}
    for x, y in situation.rivals:
        unhiding[x].add(y)
        unhiding[y].add(x)
    return Cast(situation, variables, place, frozenset([h.id for h in situation.hypotheses if h.opaque]), unhiding)


def _groups(situation: Situation) -> list[list[str]]:
    """Posterior: the hypotheses of one instance."""
    groups: dict[str, list[str]] = {}
    for h in situation.hypotheses:
        groups.setdefault(h.group, []).append(h.id)
    return list(groups.values())


def _cliques(situation: Situation) -> list[list[str]]:
    """Score: hypotheses of one group of which no two can be present together.

    Each joins the first clique that it fits.
    """
    cliques: list[list[str]] = []
    of_group: dict[str, list[list[str]]] = {}
    for h in situation.hypotheses:
        mine = of_group.setdefault(h.group, [])
        fitting = next((clique for clique in mine if _apart(situation, h.id, clique)), None) if mine else None
        if fitting is None:
            mine.append([h.id])
            cliques.append(mine[-1])
        else:
            fitting.append(h.id)
    return cliques


def _apart(situation: Situation, name: str, others: Iterable[str]) -> bool:
    """Whether constraints forbid the hypothesis to be present together with any of the others."""
    pairs = situation.overlaps, situation.exclusive
    return all(any((name, other) in some or (other, name) in some for some in pairs) for other in others)


Table: TypeAlias = Floats
"""One axis a variable."""

WIDEST = 16
"""Bits of one factor: what spans more joint states is written with auxiliary variables."""
LONGEST_LIST = 64
"""Joint states up to which plain lists are quicker than arrays."""
IMPOSSIBLE = -math.inf


def log(weight: float) -> float:
    """The natural logarithm; −inf of 0 (and of what rounding left below it)."""
    return math.log(weight) if weight > 0.0 else IMPOSSIBLE


def logs_of(weights: Iterable[float]) -> list[float]:
    """``log`` of each."""
    ln = math.log
    return [ln(weight) if weight > 0.0 else IMPOSSIBLE for weight in weights]


def too_wide(cards: Sequence[int]) -> bool:
    """Whether a factor over so many states would span more than 2^WIDEST joint states, or too many axes."""
    return len(cards) > WIDEST or math.prod(cards) > 1 << WIDEST


class Tables:
    """``unary[v][s]``, ``lists[scope]`` and ``arrays[scope]`` add up the weights of a variable and of a scope.

    Scopes of up to ``LONGEST_LIST`` joint states have lists, in C order; the others arrays. ``required`` formulas hold.
    """

    def __init__(self, cards: Sequence[int]) -> None:
        self.cards = list(cards)
        self.unary = [[0.0] * card for card in cards]
        self.lists: dict[tuple[int, ...], list[float]] = {}
        self.arrays: dict[tuple[int, ...], Table] = {}
        self.required: list[Formula] = []

    def add(self, scope: tuple[int, ...], table: Table) -> None:
        """One more factor, ``scope`` strictly increasing, one axis a variable."""
        if table.size <= LONGEST_LIST or len(scope) == 1:
            self.add_list(scope, table.ravel().tolist())
        else:
            known = self.arrays.get(scope)
            self.arrays[scope] = table if known is None else known + table

    def add_list(self, scope: tuple[int, ...], logs: list[float]) -> None:
        """As ``add``, in C order; ``logs`` becomes ours."""
        if len(scope) == 1:
            self.unary[scope[0]] = [x + y for x, y in zip(self.unary[scope[0]], logs, strict=True)]
        elif len(logs) > LONGEST_LIST:
            self.add(scope, np.array(logs).reshape(self.shape(scope)))
        else:
            known = self.lists.get(scope)
            self.lists[scope] = logs if known is None else [x + y for x, y in zip(known, logs, strict=True)]

    def forbid(self, pairs: Iterable[tuple[tuple[int, int], tuple[int, int]]]) -> None:
        """The two (variable, state) of a pair never hold together."""
        rows: dict[tuple[int, int], list[int]] = {}
        for one, other in pairs:
            (v, s), (w, t) = (one, other) if one <= other else (other, one)
            if v != w:
                rows.setdefault((v, w), []).append(s * self.cards[w] + t)
            elif s == t:
                self.unary[v][s] = IMPOSSIBLE
        for scope, mine in rows.items():
            logs = [0.0] * math.prod(self.shape(scope))
            for row in mine:
                logs[row] = IMPOSSIBLE
            self.add_list(scope, logs)

    def shape(self, scope: Sequence[int]) -> tuple[int, ...]:
        """The states of each variable."""
        cards = self.cards
        return tuple([cards[v] for v in scope])

    def variable(self, log_weights: Sequence[float]) -> int:
        """An auxiliary variable with its unary log weights; its number."""
        self.cards.append(len(log_weights))
        self.unary.append(list(log_weights))
        return len(self.cards) - 1

    def add_bits(self, literals: Sequence[Literal], logs: Sequence[float] | Table) -> None:
        """A factor given as a bit table of log weights over literals, of which several may speak of one variable."""
        if too_wide([self.cards[v] for v in {v for v, _ in literals}]):
            literals = [
                (self.indicator([literal]), (1,)) if self.cards[literal[0]] > 2 else literal for literal in literals
            ]
        self._add_rows(literals, logs)

    def _add_rows(self, literals: Sequence[Literal], logs: Sequence[float] | Table) -> None:
        bits: dict[int, list[int]] = {}
        for i, (v, states) in enumerate(literals):
            mine = bits.setdefault(v, [0] * self.cards[v])
            for s in states:
                mine[s] |= 1 << i
        scope = tuple(sorted(bits))
        if math.prod(self.shape(scope)) > LONGEST_LIST:
            self.add(scope, np.asarray(logs)[functools.reduce(np.add.outer, [np.array(bits[v]) for v in scope])])
            return
        rows = bits[scope[0]]
        for v in scope[1:]:
            mine = bits[v]
            rows = [row + bit for row in rows for bit in mine]
        self.add_list(scope, [float(logs[row]) for row in rows])

    def indicator(self, literals: Sequence[Literal]) -> int:
        """A binary variable that is 1 where one of the literals holds.

        A chain of deterministic factors of three variables each.
        """
        last: list[Literal] = []
        for literal in literals:
            inputs, new = [literal, *last], (self.variable((0.0, 0.0)), (1,))
            rows = np.arange(2 ** (len(inputs) + 1))
            holds = (rows & (1 << len(inputs)) - 1) > 0
            self._add_rows([*inputs, new], np.where(holds == (rows >> len(inputs) > 0), 0.0, IMPOSSIBLE))
            last = [new]
        return last[0][0] if last else self.variable((0.0, IMPOSSIBLE))

    def graph(self) -> FactorGraph:
        """What was added, unary factors first (those that say something), then the others by scope."""
        factors = [Factor((v,), np.array(logs)) for v, logs in enumerate(self.unary) if any(logs)]
        tables = self.arrays | {scope: np.array(logs).reshape(self.shape(scope)) for scope, logs in self.lists.items()}
        factors += [Factor(scope, tables[scope]) for scope in sorted(tables)]
        plain = FactorGraph(tuple(self.cards), tuple(factors))
        return observed(*with_formulas(plain, self.required)) if self.required else plain
