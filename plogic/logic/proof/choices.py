"""Choices, and sets of them: what an explanation consists of (§8).

* a *choice* is one alternative of the program: ``Choice(rule 7, for X = h1)`` with its heads and their probabilities
* a ``Selection`` says which head each choice takes, ``{choice: 2}``, -1 for none of them: a set of atomic choices
* an ``Allowed`` says which heads each choice may still take, ``{choice: {0, 2, -1}}``: what a refutation rests on
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.logic.proof.terms import Small

NONE = -1
SLACK = 1e-10
"""Labels that come this near to 1 leave nothing out (ProbLog's tolerance of rounding)."""


@dataclass(frozen=True)
class Choice:
    """One alternative: the rule that it comes from and what the rule's variables stand for."""

    rule: int
    values: tuple[Small, ...]
    heads: tuple[Small, ...] = field(compare=False)
    labels: tuple[float, ...] = field(compare=False)

    def probability(self, taken: int) -> float:
        """Of taking that head; of taking none of them."""
        if taken != NONE:
            return self.labels[taken]
        rest = 1.0 - sum(self.labels)
        return rest if rest > SLACK or (len(self.labels) == 1 and rest > 0) else 0.0

    @cached_property
    def domain(self) -> frozenset[int]:
        """What can be taken, with positive probability."""
        return frozenset(i for i in (*range(len(self.heads)), NONE) if self.probability(i) > 0)

    @cached_property
    def sure(self) -> int | None:
        """What it takes with probability 1, so that no explanation needs to say so; None where it is a choice indeed."""
        return next(iter(self.domain)) if len(self.domain) == 1 else None

    @cached_property
    def order(self) -> tuple[int, str]:
        """For stable ties: as the program is written, then as the values read."""
        return self.rule, str(self.values)


Selection = dict[Choice, int]
Allowed = dict[Choice, frozenset[int]]


def fixed(selection: Selection) -> Allowed:
    """A selection as what it allows."""
    return {choice: frozenset((taken,)) for choice, taken in selection.items()}


def contradicts(selection: Selection, term: Allowed) -> bool:
    """Whether no world of the selection is one of the term's."""
    return any(choice in selection and selection[choice] not in allowed for choice, allowed in term.items())


def key_of(selection: Selection) -> frozenset[tuple[Choice, int]]:
    """The selection as a set."""
    return frozenset(selection.items())


def ordered(selection: Selection) -> list[tuple[Choice, int]]:
    """As the program is written."""
    return sorted(selection.items(), key=lambda item: item[0].order)
