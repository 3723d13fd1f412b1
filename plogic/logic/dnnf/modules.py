"""Parts of a ground program that need no compiler: gates whose inputs nothing else uses, down to the choices.

Such a *module* is a tree, so its d-DNNF follows from it, in as many nodes as it has inputs; a compiler's, being made
smooth, would grow with their square. What is left for the compiler sees a module as one free variable. A gate (or a
clause that the evidence leaves) only some of whose inputs are its own gets them as one new input.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.logic.dnnf.nnf import Nnf

Clause = tuple[int, ...]
Inputs = tuple[int, ...]
"""Literals: the gate ``v ⇔ ⋁ inputs``, an AND being the negation of the OR of what is denied (``-v ⇔ ⋁ -inputs``)."""


@dataclass(frozen=True)
class Modules:
    """``gates``: literal that stands for the disjunction → its inputs, children first; ``clauses``: disjunctions that hold, of inputs of their own.

    ``left``: the clauses that are not in modules; ``size``: number of variables, new ones included.
    """

    gates: dict[int, Inputs]
    clauses: tuple[Inputs, ...]
    left: tuple[Clause, ...]
    size: int


class Splitter:
    """Finds the modules. ``gates``: as ``Modules.gates``, all that are open; ``others``: the clauses beside their definitions."""

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
            self._clause(clause)

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

    def _clause(self, clause: Clause) -> None:
        kept = self._split(clause)
        if kept is None:
            self.clauses.append(clause)
        else:
            self.left.append(kept)

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
        no = nnf.conjunction((nnf.literal(-head), none))
        nnf.stand_for(head, yes, no, whole=abs(head) not in inner)
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
