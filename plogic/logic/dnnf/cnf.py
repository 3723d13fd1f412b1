"""The ground program as clauses: Clark's completion, one outcome per alternative, the evidence; then unit propagation.

``Propagated`` is what that leaves; ``Residue``: its modules, and the components that must be compiled.

``Modules`` are gates whose inputs nothing else uses, down to the choices. Such a module is a tree, so its d-DNNF
follows from it, in as many nodes as it has inputs; a compiler's, being made smooth, would grow with their square. The
compiler sees a module as one free variable. A gate (or a clause that the evidence leaves) only some of whose inputs are
its own gets them as one new input.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.connected import roots
from plogic.base.walk import by_key
from plogic.logic.grounding.ground_program import TRUE, Gate, Ground

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from plogic.logic.dnnf.nnf import Nnf
    from plogic.logic.grounding.ground_program import Alternative

Clause = tuple[int, ...]
"""Literals of which at least one is true."""
Inputs = tuple[int, ...]
"""Literals: the gate ``v ⇔ ⋁ inputs``, an AND being the negation of the OR of what is denied (``-v ⇔ ⋁ -inputs``)."""


@dataclass(frozen=True)
class Modules:
    """``gates``: literal that stands for the disjunction → its inputs, children first.

    ``clauses``: disjunctions that hold, of inputs of their own.

    ``left``: the clauses that are not in modules; ``size``: number of variables, new ones included.
    """

    gates: dict[int, Inputs]
    clauses: tuple[Inputs, ...]
    left: tuple[Clause, ...]
    size: int


class Splitter:
    """Finds the modules.

    ``gates``: as ``Modules.gates``, all that are open; ``others``: the clauses beside their definitions.
    """

    def __init__(self, gates: dict[int, Inputs], others: Sequence[Clause], size: int) -> None:
        self.size = size
        self.uses = Counter(abs(literal) for inputs in (*gates.values(), *others) for literal in inputs)
        self.waiting = {abs(head) for head in gates}
        """Gates that are no modules, or not yet."""
        self.found: dict[int, Inputs] = {}
        self.left: list[Clause] = []
        self.clauses: list[Inputs] = []
        for head, inputs in gates.items():
            self._gate(head, inputs)
        for clause in others:
            kept = self._split(clause)
            if kept is None:
                self.clauses.append(clause)
            else:
                self.left.append(kept)

    def modules(self) -> Modules:
        """What was found."""
        return Modules(self.found, tuple(self.clauses), tuple(self.left), self.size)

    def _own(self, literal: int) -> bool:
        return self.uses[abs(literal)] == 1 and abs(literal) not in self.waiting

    def _gate(self, head: int, inputs: Inputs) -> None:
        kept = self._split(inputs)
        if kept is None:
            self.found[head] = inputs
            self.waiting.discard(abs(head))
            return
        self.left.append((-head, *kept))
        self.left += [(head, -literal) for literal in kept]

    def _split(self, inputs: Inputs) -> Inputs | None:
        """The inputs with those of its own as one; None if all are."""
        own = [literal for literal in inputs if self._own(literal)]
        if len(own) == len(inputs):
            return None
        if len(own) < 2:
            return inputs
        self.size += 1
        self.found[self.size] = tuple(own)
        self.uses[self.size] = 1
        return (*(literal for literal in inputs if not self._own(literal)), self.size)


def add_modules(nnf: Nnf, modules: Modules) -> list[int]:
    """Make the modules' nodes, which from now on stand for their literals; the nodes of the clauses that hold."""
    inner = {abs(literal) for inputs in modules.gates.values() for literal in inputs}
    for head, inputs in modules.gates.items():
        some, none = _some_none(nnf, inputs)
        yes = nnf.conjunction((nnf.literal(head), some))
        nnf.stand_for(head, yes, nnf.conjunction((nnf.literal(-head), none)), whole=abs(head) not in inner)
    return [_some_none(nnf, inputs)[0] for inputs in modules.clauses]


def _some_none(nnf: Nnf, inputs: Inputs) -> tuple[int, int]:
    """The nodes of "some input holds" and of "none does"; halves are put together, so that they are not deep."""
    if len(inputs) == 1:
        return nnf.literal(inputs[0]), nnf.literal(-inputs[0])
    half = len(inputs) // 2
    (some, none), (some_right, none_right) = _some_none(nnf, inputs[:half]), _some_none(nnf, inputs[half:])
    open_right = nnf.disjunction((some_right, none_right))
    either = nnf.disjunction((nnf.conjunction((some, open_right)), nnf.conjunction((none, some_right))))
    return either, nnf.conjunction((none, none_right))


PAIRWISE = 8
"""An alternative of up to so many outcomes excludes them pair by pair."""


IMPOSSIBLE = "no world satisfies the evidence: its probability is 0"


@dataclass(frozen=True)
class Propagated:
    """A program with its evidence after unit propagation.

    ``fixed``: variable → value; ``others``: the other clauses, without those that define an open gate.

    ``log_weight``: variable → (log weight where true, where false), 0 for what is derived; finite for every variable
    that is not fixed. ``rest``: index of an alternative → the variable that stands for none of its choices. ``size``:
    number of variables, those included.
    """

    size: int
    fixed: dict[int, bool]
    others: tuple[Clause, ...]
    log_weight: dict[int, tuple[float, float]]
    rest: dict[int, int]

    def outcomes(self, index: int, alternative: Alternative) -> list[tuple[int, float]]:
        """What an alternative may still come to: (choice, or 0 for none of them; its share)."""
        pairs = list(zip(alternative.variables, alternative.shares, strict=True))
        taken = [(v, share) for v, share in pairs if self.fixed.get(v, False)]
        none = index not in self.rest or self.fixed.get(self.rest[index], True)
        found = taken or [(v, p) for v, p in pairs if v not in self.fixed] + [(0, alternative.rest)] * none
        return [(v, share) for v, share in found if share > 0.0]


@dataclass(frozen=True)
class Residue:
    """``fixed``, ``log_weight`` and ``rest`` as of ``Propagated``; ``modules``: what needs no compiler.

    ``components``: other clauses, that share no variable with another's. ``size``: number of variables.
    """

    size: int
    fixed: dict[int, bool]
    modules: Modules
    components: tuple[tuple[Clause, ...], ...]
    log_weight: dict[int, tuple[float, float]]
    rest: dict[int, int]


def propagated(ground: Ground) -> Propagated | None:
    """The clauses of a program with its evidence, after unit propagation; None if they contradict each other.

    Of a cyclic program, what is fixed is so in every world, though the clauses hold in more than its worlds.
    """
    clauses: list[Clause] = [(literal,) for literal in ground.observed]
    owners = [0] * len(clauses)
    for variable, gate in ground.gates.items():
        clauses.extend(_completion(variable, gate))
        owners += [variable] * (len(clauses) - len(owners))
    weight: dict[int, tuple[float, float]] = {}
    rest: dict[int, int] = {}
    size = _choices(ground, clauses, weight, rest)
    found = _propagate(size, clauses)
    if found is None:
        return None
    fixed, left = found
    owners += [0] * (len(clauses) - len(owners))
    others = tuple(clause for i, clause in left.items() if not owners[i] or owners[i] in fixed)
    return Propagated(size, fixed, others, weight, rest)


def residue(ground: Ground, known: Propagated) -> Residue:
    """What is left of a program without cycles: modules, and the components that must be compiled."""
    fixed = known.fixed
    modules = Splitter(dict(_open_gates(ground, fixed)), known.others, known.size).modules()
    return Residue(modules.size, fixed, modules, components(modules.left), known.log_weight, known.rest)


def _open_gates(ground: Ground, fixed: dict[int, bool]) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Each gate that is not fixed as a disjunction, children first.

    The literal that it stands for, and its open inputs.
    """
    for variable in sorted(ground.gates.keys() - fixed.keys()):
        gate = ground.gates[variable]
        sign = 1 if gate.kind == "or" else -1
        children = gate.folded()
        yield (
            sign * variable,
            tuple(dict.fromkeys(sign * c for c in children if abs(c) not in fixed))
            if isinstance(children, tuple)
            else (),
        )


def _completion(variable: int, gate: Gate) -> Iterator[Clause]:
    """``variable ⇔ gate``."""
    sign = 1 if gate.kind == "and" else -1
    children = gate.folded()
    if not isinstance(children, tuple):
        yield (variable,) if children == TRUE else (-variable,)
        return
    yield (sign * variable, *(-sign * child for child in children))
    yield from ((-sign * variable, sign * child) for child in children)


def _choices(
    ground: Ground, clauses: list[Clause], weight: dict[int, tuple[float, float]], rest: dict[int, int]
) -> int:
    """Adds the alternatives' clauses and weights; the number of variables.

    What has probability 0 is fixed by a clause of its own.
    """
    size = ground.size
    for index, alternative in enumerate(ground.alternatives):
        clauses.extend((-v,) for v, share in zip(alternative.variables, alternative.shares, strict=True) if share == 0)
        if len(alternative.variables) == 1:
            (variable,), (share,) = alternative.variables, alternative.shares
            weight[variable] = (_log(share), math.log1p(-share) if share < 1 else -math.inf)
            clauses.extend([(variable,)] if share == 1 else [])
            continue
        outcomes = list(alternative.variables)
        weight.update({v: (_log(share), 0.0) for v, share in zip(outcomes, alternative.shares, strict=True)})
        if alternative.rest > 0:
            size += 1
            outcomes.append(size)
            rest[index] = size
            weight[size] = (math.log(alternative.rest), 0.0)
        size = _exactly_one(outcomes, clauses, size)
    return size


def _exactly_one(outcomes: list[int], clauses: list[Clause], size: int) -> int:
    """Exactly one of the outcomes.

    Many of them by a ladder of derived variables ("one of the first i"), so that clauses grow linearly.
    """
    clauses.append(tuple(outcomes))
    if len(outcomes) <= PAIRWISE:
        clauses.extend((-v, -w) for i, v in enumerate(outcomes) for w in outcomes[i + 1 :])
        return size
    before = outcomes[0]
    for outcome in outcomes[1:]:
        clauses.append((-outcome, -before))
        size += 1
        clauses.extend([(-size, before, outcome), (size, -before), (size, -outcome)])
        before = size
    return size


def _log(share: float) -> float:
    return math.log(share) if share > 0 else -math.inf


def _propagate(size: int, clauses: list[Clause]) -> tuple[dict[int, bool], dict[int, Clause]] | None:
    """Unit propagation: what is fixed, and the clauses that are left, by their places, without their false literals.

    None on a contradiction.
    """
    watch = _Watch(size, clauses)
    queue = [clause[0] for clause, count in zip(clauses, watch.open, strict=True) if count == 1]
    possible = all(watch.open)
    while queue and possible:
        possible = watch.holds(queue.pop(), queue)
    if not possible:
        return None
    value = watch.value
    fixed = {v: bool(value[v]) for v in range(1, size + 1) if value[v] or value[-v]}
    left = {
        i: tuple(lit for lit in clause if not value[-lit]) for i, clause in enumerate(clauses) if not watch.satisfied[i]
    }
    return fixed, left


class _Watch:
    """Where each literal occurs, and how many literals of each clause are not false.

    Negative literals count from the end of the lists.
    """

    def __init__(self, size: int, clauses: list[Clause]) -> None:
        self.clauses = clauses
        self.occurs: list[list[int]] = [[] for _ in range(2 * size + 1)]
        for index, clause in enumerate(clauses):
            for literal in dict.fromkeys(clause):
                self.occurs[literal].append(index)
        self.open = [len(set(clause)) for clause in clauses]
        self.value = bytearray(2 * size + 1)
        self.satisfied = bytearray(len(clauses))

    def holds(self, literal: int, queue: list[int]) -> bool:
        """Make a literal true and queue what follows from it; False on a contradiction."""
        if self.value[literal] or self.value[-literal]:
            return bool(self.value[literal])
        self.value[literal] = 1
        for index in self.occurs[literal]:
            self.satisfied[index] = 1
        for index in self.occurs[-literal]:
            self.open[index] -= 1
            if not self.satisfied[index] and self.open[index] == 1:
                queue.extend(other for other in self.clauses[index] if not self.value[-other])
            elif not self.satisfied[index] and self.open[index] == 0:
                return False
        return True


def components(clauses: Sequence[Clause]) -> tuple[tuple[Clause, ...], ...]:
    """The clauses in sets that share no variable, in the order of their first clauses."""
    joined = [tuple(map(abs, clause)) for clause in clauses]
    root = roots(1 + max((max(scope) for scope in joined), default=0), joined)
    return tuple(map(tuple, by_key(zip((root[scope[0]] for scope in joined), clauses, strict=True)).values()))
