"""A hostile program: what it tries, its text, and the door through which it comes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

BAIT = ("{py}", "{pl}", "{secret}", "{csv}", "{db}", "{new}", "{secret_folder}")
"""What a text may name: files that leave a trace when they are run or read, and one that must not be made."""


@dataclass(frozen=True)
class Hostile:
    """``tries``: what it is after, in a few words, which are its name. ``door``: see ``doors``.

    ``asked``: the goal, where the door takes one beside the text. ``bomb``: it is after time, memory or room. Else it is
    after code, files, the environment or the terminal.
    """

    tries: str
    text: str
    door: str
    asked: str = "a"
    bomb: bool = False

    def with_bait(self, paths: Mapping[str, str]) -> str:
        """The text with the paths of a run."""
        text = self.text
        for name in BAIT:
            text = text.replace(name, paths[name])
        return text


Rows = dict[str, str] | dict[str, "Callable[[], str]"]
"""What a program tries → its text, or what makes it where it is long."""


def programs(door: str, rows: Rows, *, asked: str = "a", bomb: bool = False) -> list[Hostile]:
    """The programs of one door that ask the same."""
    texts = ((tries, text if isinstance(text, str) else text()) for tries, text in rows.items())
    return [Hostile(tries, text, door, asked, bomb) for tries, text in texts]
