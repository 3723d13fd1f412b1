"""Errors of the project's ground floor.

PlogicError                   everything that a user can put right; the CLI turns one into exit code 1
└── GeometryError             a shape, number or mesh that geometry cannot work with
    └── CameraError           a camera description that is wrong; knows its file, line and key where it can
        └── WhichCameraError  a good file of many cameras, of which none was named

Every other package derives its errors from `PlogicError`. A message states the place, the rule and the value.

Many mistakes as one text: as many of them as somebody reads.

* ``Mistake``: one, at its place in a document, ``Mistake(("appearances", 3, "uv"), "a list of 1, and not of 2")``
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from geometry.printable import fit, visible

MOST = 100
"""Mistakes that are told one by one."""

Keys = tuple[str | int, ...]
"""Keys and indices from the root of a document."""


class Mistake(NamedTuple):
    """The place, from the outside in, and what is wrong there; ``at_key``: with the key itself, not with its value."""

    place: Keys
    what: str
    at_key: bool = False

    def below(self, *keys: str | int) -> "Mistake":
        """The same in the document that this one's document stands in, under these keys."""
        return Mistake((*keys, *self.place), self.what, self.at_key)

    def __str__(self) -> str:
        """``appearances.3.uv: a list of 1, and not of 2``; a key is cut to 60 characters."""
        return f"{'.'.join(f'{step!s:.60}' for step in self.place)}: {self.what}" if self.place else self.what


class PlogicError(Exception):
    """The base of every error that this project raises on purpose; `str()` is fit for a user's eyes.

    What it repeats of an input may be of any length, and hold anything: see ``geometry.printable``.
    """

    def __str__(self) -> str:
        return fit(super().__str__())


class GeometryError(PlogicError):
    """A shape, number or mesh that geometry cannot work with."""


class CameraError(GeometryError):
    """A camera description that is wrong: `file:line: key: what is wrong`, as far as each is known."""

    def __init__(self, message: str, *, path: str | Path | None = None, line: int | None = None) -> None:
        """Args: `message` is one line; `path` the file read; `line` counts from 1."""
        place = "" if path is None else f"{path}:" if line is None else f"{path}:{line}:"
        super().__init__(f"{place} {message}" if place else message)
        self.message = message
        self.path = path
        self.line = line


class WhichCameraError(CameraError):
    """A file has many cameras, and nothing tells which one is wanted."""


def told(mistakes: Sequence[object], between: str = "\n") -> str:
    """The first ``MOST`` of them on a line each, ``between`` one and the next, and how many more there are.

    >>> told(["a is wrong", "b is missing"], "; ")
    'a is wrong; b is missing'
    """
    more = len(mistakes) - MOST
    return between.join(
        [*(visible(str(mistake)) for mistake in mistakes[:MOST]), *([f"and {more} more"] if more > 0 else [])]
    )
