"""From a situation to its factor graph.

The second form of the program that ``plogic.scene.text.program_text`` writes, tested equal to it (§8).

A joint state of ``variables`` is a world, an assignment of present/1; its weight is the world's weight in the program.
Causes, hits and picks are summed out; where that would take a factor over too many hypotheses, they stay as auxiliary
variables, numbered last. Support is a soft constraint (Σc): a world weighs q, the chance that something unknown holds
it, for each hypothesis that floats in it. What the author, and who asks, observe and constrain (§9.7) are formulas that
hold, and choices of their own variables (``plogic.scene.factors.goal_meaning``).
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

from plogic.base.bounds import SLACK, bounded
from plogic.base.errors import OutsideError
from plogic.facts.situation import Situation
from plogic.facts.spatial import GROUND, Foot, Gravity
from plogic.inference.gates import And, Formula, Not, Or, observed, with_formulas
from plogic.inference.graph import FactorGraph
from plogic.scene.factors.goal_meaning import Meaning, standing
from plogic.scene.factors.posterior_factors import add_posterior
from plogic.scene.factors.score_factors import add_score
from plogic.scene.factors.support_factors import add_support
from plogic.scene.factors.weight_tables import Alternative, Cast, Choice, Literal, Tables, cast_of, logs_of

MOST_HOLDERS = 6
"""Variables of holders that one factor looks at; of more, one auxiliary variable says whether any holds."""


def add_floating(tables: Tables, cast: Cast) -> frozenset[int]:
    """One factor a hypothesis that may float. The auxiliary variables that this took, each decided by the world."""
    gravity, first = cast.situation.gravity, len(tables.cards)
    if gravity is None or bounded(gravity.unknown_support) == 1.0:
        return frozenset()
    below = None if gravity.ground is not None else _Below(tables, cast, gravity)
    for foot in gravity.feet:
        holders = gravity.holders(foot.id)
        if below is None and GROUND in holders:
            continue
        lower = None if below is None else below.literal(foot)
        if below is None or lower is not None:
            _add_foot(tables, cast, foot.id, holders, lower, math.log(bounded(gravity.unknown_support)))
    return frozenset(range(first, len(tables.cards)))


def _add_foot(tables: Tables, cast: Cast, name: str, holders: list[str], lower: Literal | None, unknown: float) -> None:
    """``unknown`` = ln q where it is present, none of ``holders`` is, and the condition ``lower``, if any, holds."""
    variable, state = cast.place[name]
    holding = cast.literals(holders)
    if len(holding) > MOST_HOLDERS:
        holding = [(tables.indicator(holding), (1,))]
    literals = [(variable, (state,)), *([] if lower is None else [lower]), *holding]
    logs = [0.0] * 2 ** len(literals)
    logs[1 if lower is None else 3] = unknown
    tables.add_bits(literals, logs)


class _Below:
    """A chain over the feet by height: whether something present is surely lower than a foot. Each step adds one."""

    def __init__(self, tables: Tables, cast: Cast, gravity: Gravity) -> None:
        self.tables, self.cast = tables, cast
        self.feet = sorted(gravity.feet, key=lambda foot: foot.high)
        self.steps: list[Literal] = []

    def literal(self, foot: Foot) -> Literal | None:
        """None where nothing is lower in any world."""
        count = sum(other.high < foot.low for other in self.feet)
        while len(self.steps) < count:
            self.steps.append(self._next(self.feet[len(self.steps)]))
        return self.steps[count - 1] if count else None

    def _next(self, foot: Foot) -> Literal:
        variable, state = self.cast.place[foot.id]
        if not self.steps:
            return variable, (state,)
        last, states = self.steps[-1]
        if last == variable:
            return last, tuple(sorted((*states, state)))
        new = self.tables.variable((0.0, 0.0))
        logs = [0.0 if (row & 3 > 0) == (row > 3) else -math.inf for row in range(8)]
        self.tables.add_bits([self.steps[-1], (variable, (state,)), (new, (1,))], logs)
        return new, (1,)


@dataclass(frozen=True)
class SceneGraph:
    """``variables[v]`` is what variable v of the graph decides.

    ``place["h4"]`` is the (variable, state) in which h4 is present.

    ``causes["a3"]``: the cause of an appearance, as a variable, if one was asked for, or that has very many claimants.
    ``decided``: auxiliary variables of which each has one possible state in a world. ``choices``: the (variable, state)
    of each choice of the author's that is spoken of. ``spoken``: whether the causes are variables since something
    speaks of them, or of what things stand on. ``support``: what they stand on, where that matters, and the
    ``footings`` that are spoken of.
    """

    graph: FactorGraph
    variables: tuple[Alternative, ...]
    place: dict[str, tuple[int, int]]
    causes: dict[str, Choice]
    decided: frozenset[int] = frozenset()
    choices: dict[tuple[str, int], tuple[int, int]] = field(default_factory=dict)
    spoken: bool = False
    support: Choice | None = None
    footings: dict[str, Choice] = field(default_factory=dict)

    @property
    def auxiliary(self) -> tuple[int, ...]:
        """The variables that are no alternative of hypotheses."""
        return tuple(range(len(self.variables), len(self.graph.cards)))

    def present(self, states: tuple[int, ...]) -> list[str]:
        """The hypotheses that are present in a joint state, by variable."""
        return [str(v.states[s]) for v, s in zip(self.variables, states, strict=False) if s]


def scene_graph(situation: Situation, *, explicit: Collection[str] = (), spoken: Sequence[Meaning] = ()) -> SceneGraph:
    """The graph of a checked situation (``plogic.facts.sanity.check``), in which the evidence of the author's holds.

    ``spoken``: goals and evidence, whose causes and choices become variables, and of which the evidence holds. Of
    appearances in ``explicit`` the cause is a variable (posterior). Raises as ``meaning``.
    """
    spoken = spoken or standing(situation)
    explicit = frozenset(explicit).union(*(meant.appearances for meant in spoken))
    cast = cast_of(situation)
    tables = Tables([len(v.states) for v in cast.variables])
    causes: dict[str, Choice] = {}
    pairs = situation.overlaps  # A4: the two are never present together
    if situation.reading == "posterior":
        causes = add_posterior(tables, cast, explicit)
    else:
        add_score(tables, cast)
        pairs |= situation.exclusive  # an appearance serves one feature
    tables.forbid([(cast.place[x], cast.place[y]) for x, y in pairs])
    decided = add_floating(tables, cast)
    footings = frozenset[str]().union(*(meant.footings for meant in spoken))
    planes = any(meant.planes for meant in spoken)
    support = add_support(tables, cast, footings, planes=planes)
    choices = _add_choices(tables, spoken)
    scene = SceneGraph(
        tables.graph(), cast.variables, cast.place, causes, decided, choices, bool(explicit) or planes, *support
    )
    return _held(scene, [formula for meant in spoken for formula in meant.formulas(meant.given, scene)])


def _add_choices(tables: Tables, spoken: Sequence[Meaning]) -> dict[tuple[str, int], tuple[int, int]]:
    """A variable an alternative of the author's, with the choices that are spoken of; state 0 is none of these."""
    if len({meant.by for meant in spoken if meant.choices}) > 1:
        raise OutsideError("choices that only ProbLog's own engine can ground are spoken of, and others", file="goal")
    shares: dict[str, dict[int, float]] = {}
    for meant in spoken:
        for name, some in meant.choices.items():
            shares.setdefault(name, {}).update(some)
    place: dict[tuple[str, int], tuple[int, int]] = {}
    for name, mine in shares.items():
        rest = 1.0 - math.fsum(mine.values())
        variable = tables.variable(logs_of([rest if len(mine) == 1 or rest > SLACK else 0.0, *mine.values()]))
        place |= {(name, number): (variable, state) for state, number in enumerate(mine, 1)}
    return place


def _held(scene: SceneGraph, formulas: Sequence[Formula]) -> SceneGraph:
    """The scene where the formulas hold; a gate over nothing but worlds and what they decide is decided by them."""
    if not formulas:
        return scene
    first, decided = len(scene.graph.cards), set(scene.decided)
    graph, literals = with_formulas(scene.graph, [part for formula in formulas for part in _conjuncts(formula)])
    for *inputs, gate in (factor.scope for factor in graph.factors[len(scene.graph.factors) :]):
        if gate >= first and all(v < len(scene.variables) or v in decided for v in inputs):
            decided.add(gate)
    return replace(scene, graph=observed(graph, literals), decided=frozenset(decided))


def _conjuncts(formula: Formula) -> Iterator[Formula]:
    """Formulas that hold together just where this one does, so that each is about a few variables."""
    stack = [formula]
    while stack:
        match stack.pop():
            case And(parts):
                stack += reversed(parts)
            case Not(Or(parts)):
                stack += [Not(part) for part in reversed(parts)]
            case Not(Not(part)):
                stack.append(part)
            case other:
                yield other
