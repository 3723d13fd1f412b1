"""A hostile program: what it tries, its text, and the door through which it comes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Hostile:
    """``tries``: what it is after, in a few words, which are its name. ``door``: see ``doors``.

    ``asked``: the goal, where the door takes one beside the text. ``bomb``: it is after time, memory or room; else it
    is after code, files, the environment or the terminal.
    """

    tries: str
    text: str
    door: str
    asked: str = "a"
    bomb: bool = False


Rows = Mapping[str, str | Callable[[], str]]
"""What a program tries → its text, or what makes it where it is long."""


def programs(door: str, rows: Rows, *, asked: str = "a", bomb: bool = False) -> list[Hostile]:
    """The programs of one door that ask the same."""
    texts = ((tries, text if isinstance(text, str) else text()) for tries, text in rows.items())
    return [Hostile(tries, text, door, asked, bomb) for tries, text in texts]
