"""A compiled program as independent factors, and each factor's states, best first.

A *state* says which of a factor's query atoms hold. The search decides one atom after the other; what it goes by is the
circuit itself, with the greatest instead of the sum wherever the branches of an OR differ in a query atom. That is
never less than the weight of any completion, and equal to it once all atoms are decided; so the first complete state
that comes up is the best (A*).
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from operator import and_, or_
from typing import TYPE_CHECKING

import numpy as np

from plogic.logic.dnnf.compiled import circuit_of
from plogic.logic.dnnf.nnf import AND, LITERAL, nodes_under

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.logic.dnnf.compiled import Circuit, Compiled, Floats
    from plogic.logic.dnnf.nnf import Nnf

State = tuple[bool, ...]
"""Whether each of a factor's query atoms holds."""
STATES_AT_ONCE = 8
"""Partial states that are taken further together."""


def bucket(log_weight: float) -> float:
    """Log weights in the same bucket, of width 1e-11, count as equal: rounding must not decide the order."""
    return round(log_weight, 11)


@dataclass(frozen=True)
class Factor:
    """A part of the circuit that shares no variable with any other.

    ``variables``: the query atoms in it, in the order in which they were asked; ``alone``: log weights of its leaves,
    ``(leaves,)``; ``total``: log weight of all its states together.
    """

    variables: tuple[int, ...]
    circuit: Circuit
    alone: Floats
    total: float

    def states(self) -> Iterator[tuple[float, State]]:
        """All possible states with ln P(state | evidence), non-increasing.

        Ties with true before false, the first atom first.
        """
        queue: list[tuple[float, tuple[int, ...], float]] = [(0.0, (), self.total)]  # marks: 0 holds, 1 does not
        while queue:
            taken = [heapq.heappop(queue)]
            if len(taken[0][1]) == len(self.variables):
                _, marks, value = taken[0]
                yield value - self.total, tuple(mark == 0 for mark in marks)
                continue
            while len(taken) < STATES_AT_ONCE and queue and len(queue[0][1]) < len(self.variables):
                taken.append(heapq.heappop(queue))
            further = [(*marks, mark) for _, marks, _ in taken for mark in (0, 1)]
            for marks, value in zip(further, self._values(further)[-1].tolist(), strict=True):
                if value > -math.inf:
                    heapq.heappush(queue, (-bucket(value - self.total), marks, value))

    def best(self, state: State) -> list[int]:
        """The literals of the most probable completion of a state; what ties goes to the circuit's first branch."""
        values = self._values([tuple(int(not holds) for holds in state)], most=True)
        return self.circuit.best(values[:, 0])

    def _values(self, decided: list[tuple[int, ...]], *, most: bool = False) -> Floats:
        leaves = np.repeat(self.alone[:, np.newaxis], len(decided), axis=1)
        for column, marks in enumerate(decided):
            excluded = [-v if mark == 0 else v for v, mark in zip(self.variables, marks, strict=False)]
            leaves[
                [self.circuit.place[literal] for literal in excluded if literal in self.circuit.place], column
            ] = -np.inf
        return self.circuit.up(leaves, most=most)


def factors_of(program: Compiled, atoms: list[int]) -> list[Factor]:
    """The factors of a program, those without query atoms, too.

    ``atoms``: variables that are open, in the order in which they were asked.
    """
    if program.circuit is None:
        return []
    nnf, values = program.nnf, program.values([()])[:, 0]
    weight = dict(zip(program.circuit.literals.tolist(), program.weights.tolist(), strict=True))
    asked = sum(1 << v for v in atoms)
    found = []
    for root in _parts(nnf):
        variables = tuple(v for v in atoms if nnf.mentions[root] >> v & 1) if nnf.mentions[root] & asked else ()
        circuit = circuit_of(nnf, root, _decided_apart(nnf, root, variables))
        alone = np.array([weight[literal] for literal in circuit.literals.tolist()])
        found.append(Factor(variables, circuit, alone, float(values[program.circuit.number[root]])))
    return found


def _parts(nnf: Nnf) -> list[int]:
    """The nodes that the root is the conjunction of, none of them a conjunction."""
    found, stack = [], [nnf.root]
    while stack:
        node = stack.pop()
        if nnf.kinds[node] == AND:
            stack.extend(reversed(nnf.children[node]))
        else:
            found.append(node)
    return found


def _decided_apart(nnf: Nnf, root: int, variables: tuple[int, ...]) -> set[int]:
    """The ORs any two of whose branches need different values of a query atom: of a state, only one branch has weight."""
    if not variables:
        return set()
    sides = {literal: 1 << (2 * i + side) for i, v in enumerate(variables) for side, literal in enumerate((v, -v))}
    yes = sum(1 << (2 * i) for i in range(len(variables)))
    needs: dict[int, int] = {}  # node → the literals of query atoms that hold wherever it does, as bits
    apart = set()
    for node in sorted(nodes_under(nnf, root)):
        below = [needs[child] for child in nnf.children[node]]
        if nnf.kinds[node] == LITERAL:
            needs[node] = sides.get(nnf.literals[node], 0)
        elif nnf.kinds[node] == AND:
            needs[node] = reduce(or_, below)
        else:
            needs[node] = reduce(and_, below)
            if all((a & yes) & (b >> 1) or (b & yes) & (a >> 1) for a, b in combinations(below, 2)):
                apart.add(node)
    return apart
