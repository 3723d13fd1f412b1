"""One row of the vocabulary of queries.

``Entry("present", 1, "the hypothesis H is in the world", "present(H)", "")``; an entry without a clause is defined by
the choices.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """``name/arity`` "is true if" ``meaning``; ``clause`` is its ProbLog text, one clause a line."""

    name: str
    arity: int
    meaning: str
    usage: str
    clause: str
    reading: str = ""

    @property
    def signature(self) -> str:
        """``present/1``."""
        return f"{self.name}/{self.arity}"
