"""A session about a program of a user's own."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from plogic.base.errors import InputError
from plogic.face.session.minds import Asked
from plogic.face.session.results import World

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.face.session.minds import Ranked
    from plogic.logic.served.engine import Limits, Text
    from plogic.logic.served.outline import Outline, Predicate

DIRECTIVES = {"query", "evidence"}
"""Predicates that say what is asked, and that nobody asks for."""


class ProgramMind(Asked):
    """Everything through the process that stays: it has the program, and what it compiled."""

    types = None

    def __init__(self, text: Text, limits: Limits | None) -> None:
        super().__init__(text, limits)
        self.text = text

    def worlds(self, n: int, given: Sequence[str]) -> Ranked:
        """The ``n`` best worlds, grouped by what the program's queries come to. One more is looked for: without it there is no rest."""
        from plogic.logic.served.engine import program_worlds

        ranking = self._through(lambda: program_worlds(self.text, n + 1, given=given, limits=self.limits))
        rows = tuple(World(w.probability, w.holds, None, (w.probability,) * 2, w.choices) for w in ranking.worlds[:n])
        return rows, rest(rows, complete=len(ranking.worlds) <= n)

    def contents(self) -> tuple[tuple[str, str], ...]:
        """Every predicate, with the number of its clauses."""
        return tuple((p.signature, p.meaning) for p in self.outline().predicates)

    def clauses(self, name: str) -> tuple[str, tuple[str, ...]]:
        """The clauses of ``wet`` or ``wet/1``."""
        return clauses_of(self.outline(), name)

    def predicates(self) -> tuple[Predicate, ...]:
        """The program's own, without its queries and evidence."""
        return tuple(p for p in self.outline().predicates if p.name not in DIRECTIVES)

    def names(self) -> tuple[tuple[str, str], ...]:
        """The program's own constants."""
        return tuple((constant, "") for constant in self.outline().constants)

    def greeting(self) -> str:
        """The file and its size."""
        found = self.predicates()
        return f"{self.text.file}: {sum(len(p.clauses) for p in found)} clauses of {len(found)} predicates"


def rest(rows: Sequence[World], *, complete: bool) -> tuple[float, float]:
    """The mass that is not in ``rows``."""
    mass = 0.0 if complete else max(0.0, 1.0 - math.fsum(row.probability for row in rows))
    return mass, mass


def clauses_of(outline: Outline, name: str) -> tuple[str, tuple[str, ...]]:
    """The clauses of every predicate of that name; raises InputError where there is none."""
    found = [p for p in outline.predicates if name in (p.name, p.signature)]
    if not found:
        raise InputError(f"listing {name}: the program has no such predicate; `listing` says what there is")
    return ", ".join(p.signature for p in found), tuple(
        line for p in found for clause in p.clauses for line in clause.splitlines()
    )
