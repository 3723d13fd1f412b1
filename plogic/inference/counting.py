"""How many of some literals hold: the distribution, exact, by a counter along each piece of a graph.

* ``counted(graph, [Literal(0, {1}), Literal(4, {1})], solve)``: intervals of P(0 hold), P(1 holds), P(2 hold)

A counter is a chain of variables: the state of the i-th is how many of the first i literals hold. Pieces that no factor
joins are counted apart, and their counts are summed as independent ones.
"""

from collections.abc import Callable, Sequence

import numpy as np

from plogic.inference.gates import Literal
from plogic.inference.graph import Beliefs, Factor, FactorGraph, split

Interval = tuple[float, float]


def counted(graph: FactorGraph, literals: Sequence[Literal], solve: Callable[[FactorGraph], Beliefs]) -> list[Interval]:
    """P(k of the literals hold), k from 0 to their number; they are of different variables."""
    left = {literal.variable: literal.states for literal in literals}
    low = high = np.ones(1)
    for part in split(graph)[1]:
        inside = [Literal(i, left.pop(v)) for i, v in enumerate(part.variables) if v in left]
        if inside:
            alone = FactorGraph(part.cards, tuple(Factor(scope, table) for scope, table in part.tables))
            mine = solve(with_counter(alone, inside))
            low, high = np.convolve(low, mine.low[-1]), np.convolve(high, mine.high[-1])
    for states in left.values():  # of one state alone, in no piece
        certain = np.eye(2)[int(0 in states)]
        low, high = np.convolve(low, certain), np.convolve(high, certain)
    return [(float(a), min(float(b), 1.0)) for a, b in zip(low, high, strict=True)]


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
