"""A program compiled once: P(any literal | any conditions) from one arithmetic circuit.

The circuit is a smooth d-DNNF as levels of numpy arrays, evaluated in log space. One upward pass weighs any number of
assignments at once (columns); one downward pass then gives the probability of every node, so of every query, given the
evidence. Upwards are logarithms, so nothing underflows: every label counts that ProbLog's parser keeps (it rounds
numbers to 15 decimals), and evidence may be as improbable as it likes. Stock ProbLog turns labels below 1e-9 into 0 and
refuses evidence below 1e-12: there our numbers are those that the text means. Downwards are probabilities given the
evidence, plain floats: below 1e-308 they are 0.
"""

from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plogic.base.errors import InconsistentError, LimitError
from plogic.base.walk import by_key
from plogic.logic.dnnf.cnf import IMPOSSIBLE, Propagated, Residue, propagated, residue
from plogic.logic.dnnf.nnf import AND, LITERAL, Nnf, nodes_under
from plogic.logic.dnnf.nnf import FALSE as NEVER
from plogic.logic.dnnf.nnf import TRUE as ALWAYS
from plogic.logic.dnnf.nnf import compiled as nnf_of
from plogic.logic.grounding.ground_program import FALSE, TRUE, Ground, Literal

BEST = 3
"""The kind of a gate that takes the greatest of its children."""
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Level:
    """The gates of one kind in one level.

    Nodes ``start`` to ``stop``, the children of the i-th from ``first[i]`` on in ``children``.

    ``owner[j]``: the gate, from 0, whose child ``children[j]`` is; ``targets[target[j]]`` is ``children[j]``, each node
    once in ``targets``.
    """

    kind: int
    start: int
    stop: int
    children: Ints
    first: Ints
    owner: Ints
    targets: Ints
    target: Ints


@dataclass(frozen=True)
class Circuit:
    """``literals``: the leaves' literals in the order of their nodes, which come first; then each level's gates.

    ``place``: literal → its leaf. ``levels`` from the leaves up; the root is the last node. ``number``: node of the
    d-DNNF → node here.
    """

    size: int
    literals: Ints
    place: dict[int, int]
    levels: tuple[Level, ...]
    number: dict[int, int]

    def up(self, leaves: Floats, *, most: bool = False) -> Floats:
        """Log weight of each node, ``(size, columns)``, from those of the leaves, ``(leaves, columns)``.

        With ``most``, an OR takes the greatest of its children and not their sum: the weight of the best completion.
        """
        values = np.empty((self.size, leaves.shape[1]))
        values[: len(self.literals)] = leaves
        for level in self.levels:
            inputs = values[level.children]
            if level.kind == AND:
                values[level.start : level.stop] = np.add.reduceat(inputs, level.first, axis=0)
            elif most or level.kind == BEST:
                values[level.start : level.stop] = np.maximum.reduceat(inputs, level.first, axis=0)
            else:
                values[level.start : level.stop] = _log_sums(inputs, level)
        return values

    def down(self, values: Floats) -> Floats:
        """P(node | what the columns condition on), ``(size,)``, of one column of ``up``; the root's must be finite."""
        flow = np.zeros(self.size)
        flow[-1] = 1.0
        for level in reversed(self.levels):
            given = flow[level.start : level.stop][level.owner]
            if level.kind != AND:
                above = values[level.start : level.stop][level.owner]
                below = values[level.children]
                given = given * np.exp(
                    np.where(np.isneginf(below), -np.inf, below - np.where(np.isneginf(above), 0.0, above))
                )
            flow[level.targets] += np.bincount(level.target, given)
        return flow

    def best(self, values: Floats) -> list[int]:
        """The literals of the best completion, from one column of ``up(most=True)``: ties go to the first child."""
        found, stack = [], [self.size - 1]
        starts = np.array([level.start for level in self.levels], dtype=np.int64)
        while stack:
            node = stack.pop()
            if node < len(self.literals):
                found.append(int(self.literals[node]))
                continue
            level = self.levels[int(np.searchsorted(starts, node, side="right")) - 1]
            i = node - level.start
            stop = level.first[i + 1] if i + 1 < len(level.first) else len(level.children)
            children = level.children[level.first[i] : stop]
            stack.extend(children.tolist() if level.kind == AND else [int(children[int(np.argmax(values[children]))])])
        return found


def _log_sums(inputs: Floats, level: Level) -> Floats:
    top = np.maximum.reduceat(inputs, level.first, axis=0)
    finite = np.where(top == -np.inf, 0.0, top)
    with np.errstate(divide="ignore"):
        sums: Floats = np.log(np.add.reduceat(np.exp(inputs - finite[level.owner]), level.first, axis=0)) + finite
    return sums


def circuit_of(nnf: Nnf, root: int | None = None, best_of: Container[int] = ()) -> Circuit:
    """The nodes under a root, in levels: leaves first, then each gate above its highest child.

    The root must not be a constant.

    The nodes ``best_of`` are ORs that take the greatest of their children and not their sum.
    """
    top = nnf.root if root is None else root
    depth = _depths(nnf, top)
    kinds = {node: BEST if node in best_of else nnf.kinds[node] for node in depth}
    order = sorted(depth, key=lambda node: (depth[node], kinds[node], node))
    number = {node: i for i, node in enumerate(order)}
    leaves = [nnf.literals[node] for node in order if kinds[node] == LITERAL]
    place = {literal: i for i, literal in enumerate(leaves)}
    groups = by_key(((depth[node], kinds[node]), node) for node in order[len(leaves) :])
    levels = tuple(_level(nnf, kind, gates, number) for (_, kind), gates in groups.items())
    return Circuit(len(order), np.array(leaves, dtype=np.int64), place, levels, number)


def _depths(nnf: Nnf, root: int) -> dict[int, int]:
    """The nodes under a root, each with its height above its lowest leaf.

    Children have smaller numbers than their parents.
    """
    depth: dict[int, int] = {}
    for node in sorted(nodes_under(nnf, root)):
        depth[node] = 1 + max((depth[child] for child in nnf.children[node]), default=-1)
    return depth


def _level(nnf: Nnf, kind: int, gates: list[int], number: dict[int, int]) -> Level:
    counts = [len(nnf.children[gate]) for gate in gates]
    children = np.fromiter((number[child] for gate in gates for child in nnf.children[gate]), dtype=np.int64)
    start = number[gates[0]]
    first = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)
    targets, target = np.unique(children, return_inverse=True)
    return Level(
        kind, start, start + len(gates), children, first, np.repeat(np.arange(len(gates)), counts), targets, target
    )


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
        """Give ln P(conditions and evidence) of each conjunction of literals, ``(len(conditions),)``.

        −inf where impossible.
        """
        return self.base + self.values(conditions)[-1]

    def values(self, conditions: Sequence[Sequence[Literal]], *, most: bool = False) -> Floats:
        """The circuit's values under each conjunction, the root's last: ``(nodes, columns)``, see ``Circuit.up``."""
        leaves = self.leaves(conditions)
        impossible = np.array(
            [
                any(self.known(literal) is False or (literal and -literal in condition) for literal in condition)
                for condition in conditions
            ],
            dtype=bool,
        )
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
        """P(literal | evidence, given) of each literal, by one upward and one downward pass.

        Raises InconsistentError.
        """
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


def compiled(ground: Ground, known: Propagated | None = None) -> Compiled:
    """The program with its evidence compiled; ``known``: what is known of it already.

    Raises InconsistentError where its probability is 0, LimitError where no compiler manages.
    """
    known = known or propagated(ground)
    if known is None:
        raise InconsistentError(IMPOSSIBLE)
    left = residue(ground, known)
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
