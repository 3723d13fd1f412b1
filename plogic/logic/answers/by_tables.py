"""A ground program as a factor graph: a variable for each alternative, gates in steps, without what evidence fixes.

The cells of its tables are a cheap estimate of the work, and an exact one: ``tables_of`` gives the graph with its order
of elimination, where that is within a limit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import unhurried
from plogic.base.errors import InconsistentError, WidthError
from plogic.inference.gates import And, Literal, Not, Or, observed, with_formulas
from plogic.inference.graph import Beliefs, Factor, FactorGraph, split
from plogic.inference.marginals import assembled, small
from plogic.inference.order import bucket_tree, elimination_order
from plogic.inference.passes import joint, two_way
from plogic.logic.dnnf.cnf import IMPOSSIBLE
from plogic.logic.grounding.ground_program import TRUE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.inference.gates import Formula
    from plogic.inference.graph import Part
    from plogic.inference.order import Bucket
    from plogic.logic.dnnf.cnf import Propagated
    from plogic.logic.grounding.ground_program import Gate, Ground
    from plogic.logic.grounding.ground_program import Literal as Key

HOLDS, FAILS = And(()), Or(())


@dataclass(frozen=True)
class Tables:
    """The graph under the evidence, its connected pieces, and the buckets of each (None: one table of all states).

    ``place``: variable of the program, if it is open → its literal in the graph; ``fixed``: the others' values;
    ``bits``: log2 of the cells of all tables together.
    """

    cards: tuple[int, ...]
    constant: float
    parts: tuple[Part, ...]
    buckets: tuple[tuple[Bucket, ...] | None, ...]
    place: dict[int, Literal]
    fixed: dict[int, bool]
    bits: float

    def probabilities(self, asked: Iterable[Key]) -> list[float]:
        """P(literal | evidence) of each literal; raises InconsistentError where the evidence is impossible."""
        solved = []
        for part, buckets in zip(self.parts, self.buckets, strict=True):
            log_z, states = (
                joint(part.cards, part.tables)
                if buckets is None
                else two_way(part.cards, part.tables, buckets, unhurried)
            )
            solved.append(Beliefs((log_z, log_z), states, states))
        found = assembled(self.cards, self.constant, self.parts, solved)
        if found.log_z[0] == -math.inf:
            raise InconsistentError(IMPOSSIBLE)
        return [self._probability(literal, found) for literal in asked]

    def _probability(self, key: Key, found: Beliefs) -> float:
        if not key or abs(key) in self.fixed:
            return float(key == TRUE if not key else self.fixed[abs(key)] == (key > 0))
        literal = self.place[abs(key)]
        belief = found.low[literal.variable]
        inside = np.array([state in literal.states for state in range(len(belief))], dtype=bool)
        yes, no = float(belief[inside].sum()), float(belief[~inside].sum())
        return (yes if key > 0 else no) / (yes + no)


def tables_of(ground: Ground, known: Propagated, most: float) -> Tables | None:
    """The graph of a program without cycles; None where its tables would have more than 2^``most`` cells together."""
    formulas: dict[int, Formula] = {}
    graph = _choices(ground, known, formulas)
    held = []
    for variable in sorted(ground.gates):
        formula = _formula(ground.gates[variable], formulas, known.fixed)
        if variable not in known.fixed:
            formulas[variable] = formula
        else:
            held.append(formula if known.fixed[variable] else Not(formula))
    whole, literals = with_formulas(graph, [*formulas.values(), *held])
    constant, parts = split(observed(whole, literals[len(formulas) :]))
    planned = _planned(parts, most)
    if planned is None:
        return None
    place = dict(zip(formulas, literals, strict=False))
    return Tables(whole.cards, constant, tuple(parts), planned[0], place, known.fixed, planned[1])


def _planned(parts: Iterable[Part], most: float) -> tuple[tuple[tuple[Bucket, ...] | None, ...], float] | None:
    """The buckets of each piece, and the bits of all together; None past the limit."""
    found: list[tuple[Bucket, ...] | None] = []
    cells = 1.0
    for part in parts:
        if small(part):
            found.append(None)
            continue
        scopes = [scope for scope, _ in part.tables]
        try:
            order = elimination_order(part.cards, scopes, most=most)
        except WidthError:
            return None
        cells += 2.0**order.work
        if cells > 2.0**most:
            return None
        found.append(bucket_tree(part.cards, scopes, order))
    return tuple(found), math.log2(cells)


def _formula(gate: Gate, formulas: dict[int, Formula], fixed: dict[int, bool]) -> Formula:
    """The gate over the formulas of its children."""
    children = tuple(_child(child, formulas, fixed) for child in gate.children)
    return And(children) if gate.kind == "and" else Or(children)


def _child(key: Key, formulas: dict[int, Formula], fixed: dict[int, bool]) -> Formula:
    if not key:
        return HOLDS if key == TRUE else FAILS
    if abs(key) in fixed:
        return HOLDS if fixed[abs(key)] == (key > 0) else FAILS
    return formulas[key] if key > 0 else Not(formulas[-key])


def _choices(ground: Ground, known: Propagated, formulas: dict[int, Formula]) -> FactorGraph:
    """A variable for each alternative, of the outcomes that the evidence leaves; one for each free variable.

    Their literals go to ``formulas``.
    """
    cards: list[int] = []
    factors: list[Factor] = []
    constants: list[float] = []
    named = set()
    for index, alternative in enumerate(ground.alternatives):
        named |= set(alternative.variables)
        outcomes = known.outcomes(index, alternative)
        for state, (choice, _) in enumerate(outcomes):
            if choice and choice not in known.fixed:
                formulas[choice] = Literal(len(cards), frozenset({state}))
        logs = np.log([share for _, share in outcomes])
        if len(outcomes) == 1:
            constants.append(float(logs[0]))
        else:
            factors.append(Factor((len(cards),), logs))
        cards.append(len(outcomes))
    for variable in range(1, ground.size + 1):
        if variable not in ground.gates and variable not in named and variable not in known.fixed:
            formulas[variable] = Literal(len(cards), frozenset({1}))
            cards.append(2)
    return FactorGraph(tuple(cards), tuple(factors), math.fsum(constants))
