"""Choices, sets of them, and the cone of a literal: the part of the ground program that it depends on, in three values.

A literal is true, false, or open as long as not every choice is made. The formula is ``plogic.logic.grounding``' ground
program, children before parents. Vocabulary (§8):

* a *choice* is one alternative of the program: ``Choice(rule 7, for X = h1)`` with its heads and their probabilities
* a ``Selection`` says which head each choice takes, ``{choice: 2}``, -1 for none of them: a set of atomic choices
* an ``Allowed`` says which heads each choice may still take, ``{choice: {0, 2, -1}}``: the ground of a refutation
* an *implicant* of a literal is an ``Allowed`` in all of whose worlds the literal is true
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from plogic.base.bounds import SLACK
from plogic.base.walk import reached
from plogic.logic.grounding.ground_program import Gate, Ground, Literal
from plogic.logic.proof.terms import Small

NONE_TAKEN = -1


@dataclass(frozen=True)
class Choice:
    """One alternative: the rule that it comes from and what the rule's variables stand for."""

    rule: int
    values: tuple[Small, ...]
    heads: tuple[Small, ...] = field(compare=False)
    labels: tuple[float, ...] = field(compare=False)

    def probability(self, taken: int) -> float:
        """Of taking that head; of taking none of them."""
        if taken != NONE_TAKEN:
            return self.labels[taken]
        rest = 1.0 - sum(self.labels)
        return rest if rest > SLACK or (len(self.labels) == 1 and rest > 0) else 0.0

    @cached_property
    def domain(self) -> frozenset[int]:
        """What can be taken, with positive probability."""
        return frozenset(i for i in (*range(len(self.heads)), NONE_TAKEN) if self.probability(i) > 0)

    @cached_property
    def sure(self) -> int | None:
        """What it takes with probability 1, so that no explanation needs to say so.

        None where it is a choice indeed.
        """
        return next(iter(self.domain)) if len(self.domain) == 1 else None

    @cached_property
    def _hash(self) -> int:
        return hash((self.rule, self.values))

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def order(self) -> tuple[int, str]:
        """For stable ties: as the program is written, then as the values read."""
        return self.rule, str(self.values)


Selection = dict[Choice, int]
Allowed = dict[Choice, frozenset[int]]


def fixed(selection: Selection) -> Allowed:
    """A selection as what it allows."""
    return {choice: frozenset((taken,)) for choice, taken in selection.items()}


def key_of(selection: Selection) -> frozenset[tuple[Choice, int]]:
    """The selection as a set."""
    return frozenset(selection.items())


def ordered(selection: Selection) -> list[tuple[Choice, int]]:
    """As the program is written."""
    return sorted(selection.items(), key=lambda item: item[0].order)


Values = dict[int, bool | None]


class StoppedError(Exception):
    """The budget of steps is used up."""


@dataclass
class Steps:
    """How many nodes may still be looked at."""

    left: int

    def take(self, count: int) -> None:
        """Raises StoppedError where they do not suffice."""
        self.left -= count
        if self.left < 0:
            raise StoppedError


@dataclass
class Cone:
    """The part of a ground program under one literal; ``atoms``: variable → the choice and which of its heads it is."""

    ground: Ground
    root: Literal
    atoms: Mapping[int, tuple[Choice, int]]
    steps: Steps
    gates: list[tuple[int, Gate]] = field(default_factory=list)
    leaves: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        def children(node: int) -> list[int]:
            gate = self.ground.gates.get(node)
            return [abs(child) for child in gate.children if child] if gate else []

        under = sorted(reached([abs(self.root)] if self.root else [], children))
        self.gates = [(v, self.ground.gates[v]) for v in under if v in self.ground.gates]
        self.leaves = [v for v in under if v in self.atoms]

    def values(self, allowed: Allowed) -> Values:
        """Every node's value in all worlds that the choices still allow; None where they differ, or may."""
        self.steps.take(len(self.gates) + len(self.leaves) + 1)
        values: Values = {}
        for v in self.leaves:
            choice, head = self.atoms[v]
            may = allowed.get(choice, choice.domain)
            values[v] = False if head not in may else True if len(may) == 1 else None
        for v, gate in self.gates:
            values[v] = _gate(gate, values)
        return values

    def counterexample(self, allowed: Allowed, wanted: bool) -> Allowed | None:  # noqa: FBT001 - a truth value
        """An implicant of "root = wanted" that agrees with what is allowed; None where no world does.

        As weak as dropping makes it.
        """
        found = self._complete(allowed, wanted)
        return None if found is None else self._weakened(found, wanted)

    def possible(self) -> bool:
        """Whether the root is true in some world."""
        return self._complete({}, True) is not None if self.root else self.root is not None  # noqa: FBT003

    def _complete(self, allowed: Allowed, wanted: bool) -> Allowed | None:  # noqa: FBT001
        values = self.values(allowed)
        value = value_of(self.root, values)
        if value is not None:
            return self._reasons(values) if value == wanted else None
        choice, first, second = self._open(values, wanted, allowed)
        for may in (first, second):
            if may:
                found = self._complete({**allowed, choice: may}, wanted)
                if found is not None:
                    return found
        return None

    def _open(self, values: Values, wanted: bool, allowed: Allowed) -> tuple[Choice, frozenset[int], frozenset[int]]:  # noqa: FBT001
        """An open choice on the way to what is wanted, and its two sides, the wanted one first."""
        node, want = abs(self.root or 0), wanted == ((self.root or 0) > 0)
        while node in self.ground.gates:
            child = next(c for c in self.ground.gates[node].children if c and value_of(c, values) is None)
            node, want = abs(child), want == (child > 0)
        choice, head = self.atoms[node]
        with_it, without = frozenset((head,)), allowed.get(choice, choice.domain) - {head}
        return (choice, with_it, without) if want else (choice, without, with_it)

    def _reasons(self, values: Values) -> Allowed:
        """What the root's value rests on: one child of an AND that is false, or of an OR that is true.

        Else all of them.
        """
        needed: Allowed = {}
        seen: set[int] = set()

        def following(node: int) -> list[int]:
            gate = self.ground.gates.get(node)
            return [abs(child) for child in _deciding(gate, values, seen)] if gate else []

        for node in reached([abs(self.root)] if self.root else [], following, seen):
            if node not in self.ground.gates:
                choice, head = self.atoms[node]
                may = frozenset((head,)) if values[node] else choice.domain - {head}
                needed[choice] = needed.get(choice, choice.domain) & may
        return needed

    def _weakened(self, implicant: Allowed, wanted: bool) -> Allowed:  # noqa: FBT001
        """Without the choices that it can do without, the least probable kept last."""
        result = dict(implicant)
        for choice in sorted(implicant, key=lambda c: c.order):
            without = {c: may for c, may in result.items() if c is not choice}
            if value_of(self.root, self.values(without)) == wanted:
                result = without
        return result


def value_of(literal: Literal, values: Values) -> bool | None:
    """A literal's value; 0 is true and None is false."""
    if not literal:
        return literal is not None
    value = values[abs(literal)]
    return value if literal > 0 or value is None else not value


def _gate(gate: Gate, values: Values) -> bool | None:
    decisive = gate.kind == "or"
    result: bool | None = not decisive
    for child in gate.children:
        value = value_of(child, values)
        if value == decisive and value is not None:
            return decisive
        if value is None:
            result = None
    return result


def _deciding(gate: Gate, values: Values, seen: set[int]) -> list[int]:
    decisive = gate.kind == "or"
    deciding = [child for child in gate.children if child and value_of(child, values) is decisive]
    if not deciding:
        return [child for child in gate.children if child]
    known = [child for child in deciding if abs(child) in seen]
    return [] if known else deciding[:1]
