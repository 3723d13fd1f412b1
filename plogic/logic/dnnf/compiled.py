"""A program compiled once: P(any literal | any conditions) from one circuit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.errors import InconsistentError, LimitError
from plogic.logic.dnnf.circuit import circuit_of
from plogic.logic.dnnf.cnf import residue
from plogic.logic.dnnf.compilers import compiled as nnf_of
from plogic.logic.dnnf.nnf import FALSE as NEVER
from plogic.logic.dnnf.nnf import TRUE as ALWAYS
from plogic.logic.grounding.ground_program import FALSE, TRUE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.logic.dnnf.circuit import Circuit, Floats
    from plogic.logic.dnnf.cnf import Residue
    from plogic.logic.dnnf.nnf import Nnf
    from plogic.logic.grounding.ground_program import Ground, Literal

IMPOSSIBLE = "no world satisfies the evidence: its probability is 0"


@dataclass(frozen=True)
class Compiled:
    """A ground program, what its evidence fixes, and the circuit of the rest (None where nothing is left open).

    ``base``: log weight of the choices that are fixed; ``weights``: those of the circuit's leaves, ``(leaves,)``.
    """

    ground: Ground
    residue: Residue
    circuit: Circuit | None
    nnf: Nnf
    weights: Floats
    base: float

    def log_mass(self, conditions: Sequence[Sequence[Literal]]) -> Floats:
        """Give ln P(conditions and evidence) of each conjunction of literals, ``(len(conditions),)``; −inf where impossible."""
        return self.base + self.values(conditions)[-1]

    def values(self, conditions: Sequence[Sequence[Literal]], *, most: bool = False) -> Floats:
        """The circuit's values under each conjunction, the root's last: ``(nodes, columns)``, see ``Circuit.up``."""
        leaves = self.leaves(conditions)
        impossible = np.array([self._contradicted(condition) for condition in conditions])
        if self.circuit is None:
            return np.where(impossible, -np.inf, 0.0)[np.newaxis, :]
        leaves[:, impossible] = -np.inf
        return self.circuit.up(leaves, most=most)

    def leaves(self, conditions: Sequence[Sequence[Literal]]) -> Floats:
        """The leaves' log weights, ``(leaves, columns)``: what contradicts a condition weighs −inf."""
        leaves = np.repeat(self.weights[:, np.newaxis], len(conditions), axis=1)
        place = {} if self.circuit is None else self.circuit.place
        for column, condition in enumerate(conditions):
            leaves[[place[-literal] for literal in condition if literal and -literal in place], column] = -np.inf
        return leaves

    def _contradicted(self, condition: Sequence[Literal]) -> bool:
        return any(self.known(literal) is False for literal in condition) or any(
            -lit in condition for lit in condition if lit
        )

    def known(self, literal: Literal) -> bool | None:
        """Whether a literal is true in every world, in none (False), or open (None)."""
        if literal is FALSE or literal == TRUE:
            return literal == TRUE
        value = self.residue.fixed.get(abs(literal))
        if value is not None:
            return value == (literal > 0)
        place = {} if self.circuit is None else self.circuit.place
        return None if literal in place and -literal in place else literal in place

    def probabilities(self, literals: Iterable[Literal], given: Sequence[Literal] = ()) -> list[float]:
        """P(literal | evidence, given) of each literal, by one upward and one downward pass; raises InconsistentError."""
        values = self.values([given])
        if np.isneginf(values[-1, 0]):
            raise InconsistentError(IMPOSSIBLE)
        flow = None if self.circuit is None else self.circuit.down(values[:, 0])
        return [self._probability(literal, flow) for literal in literals]

    def _probability(self, literal: Literal, flow: Floats | None) -> float:
        known = self.known(literal)
        if known is not None or self.circuit is None or flow is None or not literal:
            return float(known is True)
        p, q = float(flow[self.circuit.place[literal]]), float(flow[self.circuit.place[-literal]])
        return p / (p + q)


def compiled(ground: Ground) -> Compiled:
    """The program with its evidence compiled; raises InconsistentError where its probability is 0, LimitError where no compiler manages."""
    left = residue(ground)
    if left is None:
        raise InconsistentError(IMPOSSIBLE)
    nnf = nnf_of(left)
    if nnf.root == NEVER:
        raise InconsistentError(IMPOSSIBLE)
    circuit = None if nnf.root == ALWAYS else circuit_of(nnf)
    base = sum(left.log_weight[v][0 if value else 1] for v, value in left.fixed.items() if v in left.log_weight)
    program = Compiled(ground, left, circuit, nnf, _weights(left, circuit), base)
    if float(program.log_mass([()])[0]) > 1e-9 * (1 + len(left.log_weight)):
        raise LimitError(
            "the compiler returned a formula that does not represent the program: its evidence would be more than certain"
        )
    return program


def _weights(left: Residue, circuit: Circuit | None) -> Floats:
    literals = [] if circuit is None else circuit.literals.tolist()
    return np.array(
        [left.log_weight.get(abs(lit), (0.0, 0.0))[0 if lit > 0 else 1] for lit in literals], dtype=np.float64
    )
