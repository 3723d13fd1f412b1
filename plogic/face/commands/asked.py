"""Options of the commands that ask an interpretation or a program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.facts.situation import Reading

LATE = 3
"""Exit status where a deadline was reached."""


@dataclass(frozen=True)
class Asked:
    """``reading``: the other one of the same Δh, None for its own; ``deadline`` in seconds; ``rules``: a file of a user's own.

    ``trust`` lifts the allow-list of a program.
    """

    reading: Reading | None = None
    deadline: float | None = None
    trust: bool = False
    rules: str | None = None
