"""Boolean formulas over a graph's variables, made part of the graph: to be asked for, or held true.

* ``Literal(3, frozenset({1, 2}))``: variable 3 is in state 1 or 2
* ``And((Literal(3, ...), Not(Or((...,)))))``: a formula; ``And(())`` is true, ``Or(())`` is false

Each step of a conjunction becomes a binary variable (state 1: it holds) with one deterministic factor over its two
inputs (Tseitin, 1968); many inputs make a chain, so that no factor has more than three variables. A disjunction is the
negation of a conjunction of negations, a negation costs nothing, equal steps are made once, and what is certain, or
says twice the same of one variable, makes no step. No weight of a joint state of the old variables changes: each has
exactly one continuation.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plogic.inference.graph import Beliefs, Factor, FactorGraph


@dataclass(frozen=True)
class Literal:
    """The variable is in one of the ``states``."""

    variable: int
    states: frozenset[int]


@dataclass(frozen=True, eq=False)
class Not:
    """The part does not hold."""

    part: "Formula"


@dataclass(frozen=True, eq=False)
class And:
    """All parts hold."""

    parts: "tuple[Formula, ...]"


@dataclass(frozen=True, eq=False)
class Or:
    """Some part holds."""

    parts: "tuple[Formula, ...]"


Formula = Literal | Not | And | Or

_TRUE, _FALSE = Literal(-1, frozenset({0})), Literal(-1, frozenset())


def with_formulas(graph: FactorGraph, formulas: Sequence[Formula]) -> tuple[FactorGraph, tuple[Literal, ...]]:
    """Return the graph with the formulas' steps, and per formula the literal that holds exactly where it does.

    The formulas share their equal steps; the old variables keep their numbers. A formula that is certainly true, or
    false, is answered by a literal of a new variable of card 1, with or without its state.
    """
    gates = _Gates(graph)
    literals = [gates.literal(formula) for formula in formulas]
    if any(literal.variable < 0 for literal in literals):
        gates.cards.append(1)
        literals = [
            Literal(len(gates.cards) - 1, literal.states) if literal.variable < 0 else literal for literal in literals
        ]
    return FactorGraph(tuple(gates.cards), (*graph.factors, *gates.factors), graph.constant), tuple(literals)


def observed(graph: FactorGraph, literals: Iterable[Literal]) -> FactorGraph:
    """The graph where all the literals hold: what else was possible weighs −inf."""
    evidence = [
        Factor((one.variable,), np.where(_mask(graph.cards[one.variable], one.states), 0.0, -np.inf))
        for one in literals
    ]
    return FactorGraph(graph.cards, (*graph.factors, *evidence), graph.constant)


def probability(beliefs: Beliefs, literal: Literal) -> tuple[float, float]:
    """The interval of P(literal); NaN where nothing is possible."""
    low, high = beliefs.low[literal.variable], beliefs.high[literal.variable]
    inside = _mask(len(low), literal.states)
    if low is high:
        exact = min(float(low[inside].sum()), 1.0)
        return exact, exact
    return max(float(low[inside].sum()), 1.0 - float(high[~inside].sum()), 0.0), min(
        float(high[inside].sum()), 1.0 - float(low[~inside].sum()), 1.0
    )


def _mask(card: int, states: frozenset[int]) -> NDArray[np.bool_]:
    return np.array([state in states for state in range(card)], dtype=bool)


class _Gates:
    """What the formulas add to a graph."""

    def __init__(self, graph: FactorGraph) -> None:
        self.cards = list(graph.cards)
        self.factors: list[Factor] = []
        self.steps: dict[tuple[Literal, Literal], Literal] = {}
        self.known: dict[int, Literal] = {}

    def literal(self, formula: Formula) -> Literal:
        """The literal that is equivalent to the formula; parts first, without recursion, each object once."""
        stack = [formula]
        while stack:
            top = stack[-1]
            parts = _parts(top)
            wanted = [part for part in parts if id(part) not in self.known]
            if wanted and id(top) not in self.known:
                stack.extend(reversed(wanted))
                continue
            stack.pop()
            if id(top) not in self.known:
                self.known[id(top)] = self.combined(top, [self.known[id(part)] for part in parts])
        return self.known[id(formula)]

    def combined(self, formula: Formula, inputs: list[Literal]) -> Literal:
        """The literal of a formula from those of its parts."""
        match formula:
            case Literal():
                return self.simple(formula)
            case Not():
                return self.negated(inputs[0])
            case And():
                return self.conjunction(inputs)
            case Or():
                return self.negated(self.conjunction([self.negated(one) for one in inputs]))

    def simple(self, literal: Literal) -> Literal:
        """The literal, or a constant if it holds in all states or none."""
        inside = literal.states & frozenset(range(self.cards[literal.variable]))
        return (
            _FALSE
            if not inside
            else _TRUE
            if len(inside) == self.cards[literal.variable]
            else Literal(literal.variable, inside)
        )

    def negated(self, literal: Literal) -> Literal:
        """What holds exactly where the literal does not."""
        card = 1 if literal.variable < 0 else self.cards[literal.variable]
        return Literal(literal.variable, frozenset(range(card)) - literal.states)

    def conjunction(self, inputs: Sequence[Literal]) -> Literal:
        """A chain of steps over the inputs, one input a variable, by number."""
        states: dict[int, frozenset[int]] = {}
        for one in inputs:
            states[one.variable] = states.get(one.variable, one.states) & one.states
        if not all(states.values()):
            return _FALSE
        result = _TRUE
        for variable in sorted(states.keys() - {-1}):
            result = self.both(result, Literal(variable, states[variable]))
        return result

    def both(self, left: Literal, right: Literal) -> Literal:
        """One step: where both hold."""
        if left.variable < 0:
            return right if left.states else _FALSE
        if left.variable == right.variable:
            return self.simple(Literal(left.variable, left.states & right.states))
        if (left, right) not in self.steps:
            first, second = sorted((left, right), key=lambda one: one.variable)
            self.steps[left, right] = self.gate(first, second)
        return self.steps[left, right]

    def gate(self, first: Literal, second: Literal) -> Literal:
        """A new binary variable that is 1 exactly where both hold."""
        holds = np.outer(
            _mask(self.cards[first.variable], first.states), _mask(self.cards[second.variable], second.states)
        )
        new = len(self.cards)
        self.cards.append(2)
        self.factors.append(
            Factor((first.variable, second.variable, new), np.where(np.stack([~holds, holds], axis=-1), 0.0, -np.inf))
        )
        return Literal(new, frozenset({1}))


def _parts(formula: Formula) -> tuple[Formula, ...]:
    match formula:
        case Literal():
            return ()
        case Not():
            return (formula.part,)
        case _:
            return formula.parts
