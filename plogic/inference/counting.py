"""How many of some literals hold: the distribution, exact, by a counter along each piece of a graph.

* ``counted(graph, [Literal(0, {1}), Literal(4, {1})], solve)``: intervals of P(0 hold), P(1 holds), P(2 hold)

A counter is a chain of variables: the state of the i-th is how many of the first i literals hold. Pieces that no factor
joins are counted apart, and their counts are summed as independent ones.
"""

from collections.abc import Callable, Sequence

import numpy as np

from plogic.inference.gates import Literal
from plogic.inference.graph import Beliefs, Factor, FactorGraph, connected

Interval = tuple[float, float]


def counted(graph: FactorGraph, literals: Sequence[Literal], solve: Callable[[FactorGraph], Beliefs]) -> list[Interval]:
    """P(k of the literals hold), k from 0 to their number; they are of different variables."""
    low = high = np.ones(1)
    for piece in connected(graph):
        inside = [literal for literal in literals if literal.variable in piece]
        if inside:
            part, number = part_of(graph, piece)
            mine = solve(with_counter(part, [Literal(number[one.variable], one.states) for one in inside]))
            low, high = np.convolve(low, mine.low[-1]), np.convolve(high, mine.high[-1])
    return [(float(a), min(float(b), 1.0)) for a, b in zip(low, high, strict=True)]


def part_of(graph: FactorGraph, variables: Sequence[int]) -> tuple[FactorGraph, dict[int, int]]:
    """Some whole pieces alone, with the new number of each variable."""
    number = {v: i for i, v in enumerate(sorted(variables))}
    factors = tuple(
        Factor(tuple(number[v] for v in factor.scope), factor.table)
        for factor in graph.factors
        if factor.scope and factor.scope[0] in number
    )
    return FactorGraph(tuple(graph.cards[v] for v in sorted(variables)), factors), number


def with_counter(graph: FactorGraph, literals: Sequence[Literal]) -> FactorGraph:
    """The graph with a chain of counters, of which the last, its last variable, counts all of the literals."""
    cards, factors = list(graph.cards), list(graph.factors)
    before = 0  # what a counter of nothing would be
    for i, literal in enumerate(literals):
        holds = np.array([state in literal.states for state in range(graph.cards[literal.variable])])
        table = np.full((len(holds), i + 1, i + 2), -np.inf)
        for count in range(i + 1):
            table[holds, count, count + 1] = 0.0
            table[~holds, count, count] = 0.0
        scope = (literal.variable, before, len(cards)) if i else (literal.variable, len(cards))
        factors.append(Factor(scope, table if i else table[:, 0]))
        before = len(cards)
        cards.append(i + 2)
    return FactorGraph(tuple(cards), tuple(factors), graph.constant)
