"""Probabilities of queries by sentential decision diagrams over the choices alone (PySDD, as stock ProbLog does).

Gates become diagrams, children first. Gates that depend on each other start false and are computed anew until none
changes: the least fixed point, since no negation is among them (J. Vlasselaer et al., Anytime inference in
probabilistic logic programs with Tp-compilation, 2015). So no cycle is broken, which would copy what is on it.

An alternative of many choices is decided one choice after another, each with its probability given that no earlier one
came. So every variable weighs 1 in sum, and no diagram need be made smooth. What the evidence fixes is left out.

The diagrams are ordered (right-linear), along a sweep over the program, which keeps those of graphs small. Work is
counted in nodes, not in seconds: the same program gives up at the same place.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InconsistentError
from plogic.inference.order import neighbours, sweep
from plogic.logic.dnnf.cnf import IMPOSSIBLE
from plogic.logic.grounding.ground_program import TRUE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.logic.dnnf.cnf import Propagated
    from plogic.logic.grounding.ground_program import Gate, Ground, Literal

WIDE = 100
"""Children of a gate from which on every pair of them is too much: a ``findall`` over nine choices has 512 results; its
process took 2.4 s of the processor with tables and takes 0.36 s without. Over twelve choices, 4,096 results,
it takes 4.2 s with pairs and 1.9 s without."""
LEAST_MASS = 1e-200
"""Evidence less probable than that would be rounded: another way is asked."""


class GiveUpError(Exception):
    """The diagrams grow past the limit, or cannot be made; another way is to be asked."""


class Diagrams:
    """The diagrams of a program's gates; ``weight``: variable → its probability."""

    def __init__(self, ground: Ground, known: Propagated, most: int) -> None:
        """``most``: nodes that may be made."""
        try:
            from pysdd.sdd import SddManager, Vtree
        except ImportError:
            raise GiveUpError from None
        self.ground, self.fixed, self.most = ground, known.fixed, most
        self.weight: list[float] = [0.0]
        drawn = _draws(ground, known, self.weight)
        self.manager = SddManager.from_vtree(Vtree(len(self.weight) - 1, _order(ground, drawn), "right"))
        self.of: dict[int, Any] = {}
        self.holds = self.manager.true()
        self.sums: dict[int, float] = {}
        for choice, literals in drawn.items():
            self.of[choice] = self._fold("and", [self.manager.literal(one) for one in literals])
        for block in blocks(ground.gates):
            self._block(block)

    def probabilities(self, asked: Iterable[Literal]) -> list[float]:
        """P(literal | evidence) of each literal; raises InconsistentError where the evidence is impossible."""
        if self.holds.is_false():
            raise InconsistentError(IMPOSSIBLE)
        total = self._mass(self.holds)
        if total < LEAST_MASS:
            raise GiveUpError
        return [self._probability(literal, total) for literal in asked]

    def _probability(self, literal: Literal, total: float) -> float:
        if not literal:
            return float(literal == TRUE)
        if abs(literal) in self.fixed:
            return float(self.fixed[abs(literal)] == (literal > 0))
        both = self._both("and", self._diagram(literal), self.holds)
        return 1.0 if both.id == self.holds.id else min(self._mass(both) / total, 1.0)

    def _block(self, block: Sequence[int]) -> None:
        """Gates that depend on each other, or one that does not."""
        inner = set(block)
        if len(block) == 1 and not any(abs(child or 0) in inner for child in self.ground.gates[block[0]].children):
            self.of[block[0]] = self._gate(self.ground.gates[block[0]], frozenset())
        else:
            self._fixed_point(block, inner)
        for variable in block:
            if variable in self.fixed:
                made = self.of[variable]
                self.holds = self._both("and", self.holds, made if self.fixed[variable] else self.manager.negate(made))

    def _fixed_point(self, block: Sequence[int], inner: set[int]) -> None:
        gates = self.ground.gates
        if any(child and child < 0 and -child in inner for variable in block for child in gates[variable].children):
            raise GiveUpError
        self.of |= dict.fromkeys(block, self.manager.false())
        users: dict[int, list[int]] = {variable: [] for variable in block}
        for variable in block:
            for child in gates[variable].children:
                if child and child in inner:
                    users[child].append(variable)
        waiting = dict.fromkeys(block)
        while waiting:
            variable = next(iter(waiting))
            del waiting[variable]
            made = self._gate(gates[variable], inner)
            if made.id != self.of[variable].id:
                self.of[variable] = made
                waiting |= dict.fromkeys(users[variable])

    def _gate(self, gate: Gate, inner: Iterable[int]) -> Any:  # noqa: ANN401 - PySDD has no types
        """The diagram of a gate; what is fixed outside of ``inner`` is a constant."""
        return self._fold(gate.kind, [self._child(child, inner) for child in gate.children])

    def _child(self, child: Literal, inner: Any) -> Any:  # noqa: ANN401
        if not child:
            return self.manager.true() if child == TRUE else self.manager.false()
        if abs(child) in self.fixed and abs(child) not in inner:
            return self.manager.true() if self.fixed[abs(child)] == (child > 0) else self.manager.false()
        return self._diagram(child)

    def _diagram(self, literal: int) -> Any:  # noqa: ANN401
        made = self.of[abs(literal)]
        return made if literal > 0 else self.manager.negate(made)

    def _fold(self, kind: str, parts: Iterable[Any]) -> Any:  # noqa: ANN401
        made = self.manager.true() if kind == "and" else self.manager.false()
        for part in parts:
            made = self._both(kind, made, part)
        return made

    def _both(self, kind: str, left: Any, right: Any) -> Any:  # noqa: ANN401
        if self.manager.count() > self.most:
            raise GiveUpError
        return self.manager.conjoin(left, right) if kind == "and" else self.manager.disjoin(left, right)

    def _mass(self, root: Any) -> float:  # noqa: ANN401
        """The probability of a diagram; what was weighed once is remembered."""
        stack = [root]
        while stack:
            node = stack[-1]
            if node.id in self.sums:
                stack.pop()
            elif node.is_true() or node.is_false():
                self.sums[node.id] = float(node.is_true())
            elif node.is_literal():
                p = self.weight[abs(node.literal)]
                self.sums[node.id] = p if node.literal > 0 else 1.0 - p
            else:
                elements = node.elements()
                open_ = [child for pair in elements for child in pair if child.id not in self.sums]
                stack.extend(open_)
                if not open_:
                    self.sums[node.id] = math.fsum(self.sums[p.id] * self.sums[s.id] for p, s in elements)
        return self.sums[root.id]


def _draws(ground: Ground, known: Propagated, weight: list[float]) -> dict[int, list[int]]:
    """Choice → the literals of which it is the conjunction; adds the variables' probabilities."""
    found: dict[int, list[int]] = {}
    named: set[int] = set()
    for index, alternative in enumerate(ground.alternatives):
        named |= set(alternative.variables)
        outcomes = [] if known.fixed.keys() >= set(alternative.variables) else known.outcomes(index, alternative)
        earlier: list[int] = []
        for i, (choice, share) in enumerate(outcomes[:-1]):
            weight.append(share / math.fsum(p for _, p in outcomes[i:]))
            found[choice] = [*earlier, len(weight) - 1]
            earlier.append(-len(weight) + 1)
        if outcomes and outcomes[-1][0]:
            found[outcomes[-1][0]] = earlier
    for variable in range(1, ground.size + 1):
        if variable not in named and variable not in ground.gates and variable not in known.fixed:
            weight.append(0.5)
            found[variable] = [len(weight) - 1]
    if len(weight) == 1:
        weight.append(0.5)  # a manager has a variable
    return found


def _order(ground: Ground, drawn: dict[int, list[int]]) -> list[int]:
    """The variables of the diagrams in the order in which a sweep meets their choices; ``drawn`` in its own order.

    Children of one gate are neighbours; of a wide one each is the gate's alone, for pairs grow by the square.
    """
    count = ground.size + 1
    scopes: list[tuple[int, ...]] = []
    for variable, gate in ground.gates.items():
        children = [abs(child) for child in gate.children if child]
        scopes += [(variable, *children)] if len(children) <= WIDE else [(variable, child) for child in children]
    turn = {v: i for i, v in enumerate(sweep(neighbours(count, scopes), [1.0] * count))}
    choices = sorted(drawn, key=turn.__getitem__)
    return list(dict.fromkeys(abs(literal) for choice in choices for literal in drawn[choice])) or [1]


def blocks(gates: dict[int, Gate]) -> list[list[int]]:
    """Gates that depend on each other, together, each block after those that it depends on (R. Tarjan, 1972)."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    path: list[int] = []
    found: list[list[int]] = []
    placed: set[int] = set()
    for root in gates:
        stack = [(root, iter(_gates_under(gates, root)))] if root not in index else []
        while stack:
            top, children = stack[-1]
            if top not in index:
                index[top] = low[top] = len(index)
                path.append(top)
            for child in children:
                if child not in index:
                    stack.append((child, iter(_gates_under(gates, child))))
                    break
                if child not in placed:
                    low[top] = min(low[top], low[child])
            else:
                stack.pop()
                if stack:
                    low[stack[-1][0]] = min(low[stack[-1][0]], low[top])
                if low[top] == index[top]:
                    start = path.index(top)
                    found.append(path[start:])
                    placed |= set(found[-1])
                    del path[start:]
    return found


def _gates_under(gates: dict[int, Gate], variable: int) -> list[int]:
    return [abs(child) for child in gates[variable].children if child and abs(child) in gates]
