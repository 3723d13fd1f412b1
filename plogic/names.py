"""Names of users and atoms of programs, and the table between them (contract, "Names").

A name that matches ``[a-z][a-z0-9_]*`` and is no operator is its own atom; any other gets a generated one (``f1`` for
a feature's path, ``n1`` for the rest). Atoms stand only in argument places, so no name can be read as program text.

Vocabulary: a *label* is what the user wrote, ``"roof/apex"``; an *atom* is what programs say, ``"f1"``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from plogic.pair_facts import both_ways

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from plogic.situation import HypothesisFact, Situation

SIMPLE = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
OPERATORS = frozenset({"is", "mod", "rem", "div", "rdiv", "not", "xor", "as", "rule", "dynamic", "discontiguous", "initialization"})
"""Words that ProbLog's parser reads, or could read, as something else than a constant."""


@dataclass(frozen=True)
class Names:
    """The two directions of one table; built once, then only read."""

    atoms: dict[str, str]
    labels: dict[str, str]

    def atom(self, label: str) -> str:
        """The atom of a label; a label that the table does not know is a mistake of ours (KeyError)."""
        return self.atoms[label]

    def generated(self) -> list[tuple[str, str]]:
        """(atom, label) of every name that is not its own atom, in the order of the table."""
        return [(atom, label) for label, atom in self.atoms.items() if atom != label]


def names_of(situation: Situation) -> Names:
    """The table of one situation: deterministic, in the order in which the names appear there."""
    wanted = list(_labels(situation))
    taken = {label for label, _ in wanted if own_atom(label)}
    atoms: dict[str, str] = {}
    counters = {"f": 0, "n": 0}
    for label, kind in wanted:
        if label not in atoms:
            atoms[label] = label if own_atom(label) else _fresh(kind, counters, taken)
    return Names(atoms, {atom: label for label, atom in atoms.items()})


def own_atom(label: str) -> bool:
    """Whether the label is its own atom."""
    return SIMPLE.fullmatch(label) is not None and label not in OPERATORS


def _fresh(kind: str, counters: dict[str, int], taken: set[str]) -> str:
    while True:
        counters[kind] += 1
        atom = f"{kind}{counters[kind]}"
        if atom not in taken:
            return atom


def _labels(situation: Situation) -> Iterator[tuple[str, str]]:
    for hypothesis in situation.hypotheses:
        yield from ((label, "n") for label in (hypothesis.id, hypothesis.type, hypothesis.group))
        yield from _inner_labels(hypothesis)
    for appearance in situation.appearances:
        yield from ((label, "n") for label in (appearance.id, appearance.type))
    for table in (situation.dv, situation.rank, situation.priors):
        yield from ((label, "n") for label in table)
    for fact in (*situation.relations, *situation.part_relations):
        yield from _each((fact.relation, *both_ways(fact)))


def _inner_labels(hypothesis: HypothesisFact) -> Iterator[tuple[str, str]]:
    for part in hypothesis.parts:
        yield part.id, "f"
        yield part.type, "n"
    for feature in hypothesis.features:
        yield feature.id, "f"
        yield feature.type, "n"


def _each(labels: Iterable[str]) -> Iterator[tuple[str, str]]:
    yield from ((label, "n") for label in labels)
