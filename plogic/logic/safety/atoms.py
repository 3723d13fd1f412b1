"""Names of users and atoms of programs, and the table between them (contract, "Names").

A name that matches ``[a-z][a-z0-9_]*`` and is no operator is its own atom; any other gets a generated one. Atoms stand
only in argument places, so no name can be read as program text.

Vocabulary: a *label* is what the user wrote, ``"roof/apex"``; an *atom* is what programs say, ``"f1"``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

SIMPLE = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
OPERATORS = frozenset(
    {"is", "mod", "rem", "div", "rdiv", "not", "xor", "as", "rule", "dynamic", "discontiguous", "initialization"}
)
"""Words that ProbLog's parser reads, or could read, as something else than a constant."""

SPELLINGS = {("atom", 1): "atom_node"}
"""Predicates that ProbLog already has: what a user writes → what programs say; mapped on the syntax tree."""


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


def own_atom(label: str) -> bool:
    """Whether the label is its own atom."""
    return SIMPLE.fullmatch(label) is not None and label not in OPERATORS
