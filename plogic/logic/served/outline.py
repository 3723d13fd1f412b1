"""What a program consists of.

Its predicates with their clauses, and its constants, as the session's process reads them.

Vocabulary: ``Predicate("wet", 0, "wet", "", ("wet :- rain.",))``; ``Outline((Predicate(...), ...), ("front",
"back"))``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plogic.logic.safety.atoms import Names, quoted


@dataclass(frozen=True)
class Predicate:
    """``name/arity`` with what is known of it: how it is used, what it means, its clauses."""

    name: str
    arity: int
    usage: str
    meaning: str
    clauses: tuple[str, ...] = ()

    @property
    def signature(self) -> str:
        """``wet/0``."""
        return f"{self.name}/{self.arity}"


@dataclass(frozen=True)
class Outline:
    """The predicates in the order in which the program defines them; the constants in the order in which they occur."""

    predicates: tuple[Predicate, ...]
    constants: tuple[str, ...]


def outline_of(reply: Mapping[str, Any]) -> Outline:
    """The outline in a reply of the process."""
    predicates = tuple(
        Predicate(
            name,
            arity,
            name if not arity else f"{name}({', '.join('_' * arity)})",
            f"{len(clauses)} clause{'s' * (len(clauses) != 1)}",
            tuple(clauses),
        )
        for name, arity, clauses in reply["predicates"]
    )
    return Outline(predicates, tuple(reply["constants"]))


def outline_request(texts: list[dict[str, str]], names: Names | None) -> dict[str, Any]:
    """What the process is asked; with ``names`` the clauses come with labels for atoms."""
    atoms = None if names is None else {atom: quoted(label) for atom, label in names.labels.items()}
    return {"task": "outline", "texts": texts, "labels": atoms}
