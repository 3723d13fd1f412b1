"""Choices, and sets of them: what an explanation consists of (§8).

* a *choice* is one alternative of the program: ``Choice(rule 7, for X = h1)`` with its heads and their probabilities
* a ``Selection`` says which head each choice takes, ``{choice: 2}``, -1 for none of them
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from plogic.proof.terms import Small

NONE = -1
WIDEST = 200
"""Explanations of one goal that are followed; the least probable are left out beyond that."""


@dataclass(frozen=True)
class Choice:
    """One alternative: the rule that it comes from and what the rule's variables stand for."""

    rule: int
    values: tuple[Small, ...]
    heads: tuple[Small, ...] = field(compare=False)
    labels: tuple[float, ...] = field(compare=False)
    is_fact: bool = field(compare=False, default=True)

    def probability(self, taken: int) -> float:
        """Of taking that head; of taking none of them."""
        return max(0.0, 1.0 - sum(self.labels)) if taken == NONE else self.labels[taken]

    def others(self, taken: int) -> list[int]:
        """What else can be taken, with positive probability."""
        return [i for i in (*range(len(self.heads)), NONE) if i != taken and self.probability(i) > 1e-12]


Selection = dict[Choice, int]


def merged(x: Selection, y: Selection) -> Selection | None:
    """Both together; None where they take different heads of one choice."""
    if any(x.get(choice, taken) != taken for choice, taken in y.items()):
        return None
    return {**x, **y}


def probability(selection: Selection) -> float:
    """The product of its choices' probabilities."""
    return prod(choice.probability(taken) for choice, taken in selection.items())


def breaking(proofs: Iterable[Selection]) -> list[Selection]:
    """The minimal selections that contradict every one of the proofs: the explanations of the negated goal."""
    found: list[Selection] = [{}]
    for proof in proofs:
        found = best([wider for selection in found for wider in _contradicting(selection, proof)])
    return found


def _contradicting(selection: Selection, proof: Selection) -> list[Selection]:
    if merged(selection, proof) is None:
        return [selection]
    free = [(choice, taken) for choice, taken in proof.items() if choice not in selection]
    return [{**selection, choice: other} for choice, taken in free for other in choice.others(taken)]


def best(selections: list[Selection]) -> list[Selection]:
    """Without supersets of others, most probable first, at most ``WIDEST``."""
    ranked = sorted(selections, key=lambda s: (-probability(s), len(s)))
    kept: list[Selection] = []
    for selection in ranked:
        if not any(smaller.items() <= selection.items() for smaller in kept):
            kept.append(selection)
        if len(kept) == WIDEST:
            break
    return kept
