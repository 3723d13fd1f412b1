"""P(formula) on a graph, piece by piece: what touches independent pieces as a conjunction multiplies.

The rest takes gates.

Vocabulary: a *piece* is a connected component of the graph; ``Asked`` has solved a graph once and answers any number of
formulas.
"""

import math
import time
from collections.abc import Callable, Iterable, Sequence

from plogic.base.errors import InconsistentError, OutsideError
from plogic.facts.situation import Situation, names_of
from plogic.inference.gates import And, Formula, Literal, Not, Or, observed, probability, with_formulas
from plogic.inference.graph import Beliefs, Factor, FactorGraph, connected
from plogic.inference.marginals import beliefs
from plogic.logic.safety.atoms import quoted
from plogic.logic.served.engine import Limits, run
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.text.program_text import program_of

Interval = tuple[float, float]
States = dict[int, frozenset[int]]


class Asked:
    """``solve`` is ``plogic.inference.marginals.beliefs``, or one that remembers."""

    def __init__(self, graph: FactorGraph, solve: Callable[[FactorGraph], Beliefs]) -> None:
        self.graph, self.solve = graph, solve
        self.beliefs = solve(graph)
        if self.beliefs.log_z[1] == -math.inf:
            raise InconsistentError("no world satisfies the evidence: its probability is 0")
        self._pieces = connected(graph)
        self._of = {v: i for i, piece in enumerate(self._pieces) for v in piece}
        self._factors: dict[int, list[Factor]] = {}
        for factor in graph.factors:
            if factor.scope:
                self._factors.setdefault(self._of[factor.scope[0]], []).append(factor)
        self._known: dict[tuple[tuple[int, frozenset[int]], ...], Interval] = {}
        self._beside: dict[tuple[int, frozenset[int]], tuple[Beliefs, dict[int, int]]] = {}

    def probability(self, formula: Formula) -> Interval:
        """P(formula): both ends are the same but where ``solve`` reached a deadline."""
        states = conjunction(formula, self.graph.cards)
        if states is not None:
            return self._conjunction(states)
        graph, number = self._part(sorted({self._of[literal.variable] for literal in literals(formula)}))
        more, (literal,) = with_formulas(graph, (renumbered(formula, number),))
        return probability(self.solve(more), literal)

    def _conjunction(self, states: States) -> Interval:
        by_piece: dict[int, States] = {}
        for v, inside in states.items():
            by_piece.setdefault(self._of[v], {})[v] = inside
        found = [self._within(by_piece[piece]) for piece in sorted(by_piece)]
        return math.prod(low for low, _ in found), math.prod(high for _, high in found)

    def _within(self, states: States) -> Interval:
        """P(all of it), within one piece."""
        if len(states) == 1:
            ((v, inside),) = states.items()
            return probability(self.beliefs, Literal(v, inside))
        key = tuple(sorted(states.items(), key=lambda item: item[0]))
        if len(key) == 2:
            return self._pair(*key)
        if key not in self._known:
            graph, number = self._part([self._of[key[0][0]]])
            held = observed(graph, [Literal(number[v], inside) for v, inside in key])
            self._known[key] = _ratio(self.solve(held).log_z, self.solve(graph).log_z)
        return self._known[key]

    def _pair(self, one: tuple[int, frozenset[int]], other: tuple[int, frozenset[int]]) -> Interval:
        """P(one) · P(other | one): where the one holds, the piece is solved once for all others."""
        alone = probability(self.beliefs, Literal(*one))
        if alone[1] <= 0.0:
            return 0.0, 0.0
        if one not in self._beside:
            graph, number = self._part([self._of[one[0]]])
            self._beside[one] = self.solve(observed(graph, [Literal(number[one[0]], one[1])])), number
        solved, number = self._beside[one]
        if solved.log_z[1] == -math.inf:
            return 0.0, 0.0
        beside = probability(solved, Literal(number[other[0]], other[1]))
        return alone[0] * beside[0], min(alone[1] * beside[1], 1.0)

    def _part(self, touched: list[int]) -> tuple[FactorGraph, dict[int, int]]:
        """The pieces alone, with the new number of each variable."""
        variables = [v for piece in touched for v in self._pieces[piece]]
        number = {v: i for i, v in enumerate(sorted(variables))}
        factors = tuple(
            Factor(tuple(number[v] for v in factor.scope), factor.table)
            for piece in touched
            for factor in self._factors.get(piece, ())
        )
        return FactorGraph(tuple(self.graph.cards[v] for v in sorted(variables)), factors), number


def together(situation: Situation, pairs: Sequence[tuple[str, str]], seconds: float | None = None) -> list[Interval]:
    """P(both are present) of each pair of hypotheses, exact, or what is known by a deadline.

    Raises InconsistentError where no world is possible.
    """
    if not pairs:
        return []
    try:
        scene = scene_graph(situation)
    except OutsideError:
        return _by_text(situation, pairs, seconds)
    end = None if seconds is None else time.monotonic() + seconds
    asked = Asked(
        scene.graph, lambda graph: beliefs(graph, seconds=None if end is None else max(end - time.monotonic(), 0.0))
    )
    return [
        asked.probability(And(tuple(Literal(v, frozenset({s})) for v, s in (scene.place[h] for h in pair))))
        for pair in pairs
    ]


def _by_text(situation: Situation, pairs: Sequence[tuple[str, str]], seconds: float | None) -> list[Interval]:
    goals = [", ".join(f"present({quoted(h)})" for h in pair) for pair in pairs]
    limits = Limits() if seconds is None else Limits(seconds=seconds)
    found = run([program_of(situation)], goals, names=names_of(situation), limits=limits)
    return [answer.interval for (answer,) in found]


def _ratio(part: Interval, whole: Interval) -> Interval:
    """exp(part − whole), of intervals of logarithms; at most 1."""
    low = 0.0 if part[0] == -math.inf else min(math.exp(part[0] - whole[1]), 1.0)
    high = 0.0 if part[1] == -math.inf else 1.0 if part[1] >= whole[0] else math.exp(part[1] - whole[0])
    return low, high


def conjunction(formula: Formula, cards: tuple[int, ...]) -> States | None:
    """The states that each variable may be in, if the formula is a conjunction of literals; None if it is not."""
    states: States = {}
    stack = [formula]
    while stack:
        match stack.pop():
            case Literal(variable, inside):
                states[variable] = states.get(variable, inside) & inside
            case Not(Literal(variable, inside)):
                stack.append(Literal(variable, frozenset(range(cards[variable])) - inside))
            case Not(Not(part)):
                stack.append(part)
            case Not(Or(parts)):
                stack += [Not(part) for part in parts]
            case And(parts):
                stack += parts
            case _:
                return None
    return states


def literals(formula: Formula) -> list[Literal]:
    """The literals in a formula, each object once."""
    found: list[Literal] = []
    stack, seen = [formula], set[int]()
    while stack:
        top = stack.pop()
        if id(top) not in seen:
            seen.add(id(top))
            found += [top] if isinstance(top, Literal) else []
            stack += _parts(top)
    return found


def renumbered(formula: Formula, number: dict[int, int]) -> Formula:
    """The formula over other numbers of its variables; parts that are shared stay shared."""
    made: dict[int, Formula] = {}
    stack = [formula]
    while stack:
        top = stack[-1]
        wanted = [part for part in _parts(top) if id(part) not in made]
        stack += wanted
        if not wanted:
            made[id(top)] = _rebuilt(stack.pop(), made, number)
    return made[id(formula)]


def _rebuilt(formula: Formula, made: dict[int, Formula], number: dict[int, int]) -> Formula:
    match formula:
        case Literal(variable, states):
            return Literal(number[variable], states)
        case Not(part):
            return Not(made[id(part)])
        case And(parts):
            return And(tuple(made[id(part)] for part in parts))
        case Or(parts):
            return Or(tuple(made[id(part)] for part in parts))


def _parts(formula: Formula) -> Iterable[Formula]:
    match formula:
        case Literal():
            return ()
        case Not(part):
            return (part,)
        case _:
            return formula.parts
