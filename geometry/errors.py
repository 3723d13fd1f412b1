"""Errors of the project's ground floor.

PlogicError                   everything that a user can put right; the CLI turns one into exit code 1
└── GeometryError             a shape, number or mesh that geometry cannot work with
    └── CameraError           a camera description that is wrong; knows its file, line and key where it can

Every other package derives its errors from `PlogicError`. A message states the place, the rule and the value.

Many mistakes as one text: as many of them as somebody reads.
"""

from collections.abc import Sequence
from pathlib import Path

MOST = 100
"""Mistakes that are told one by one."""


class PlogicError(Exception):
    """The base of every error that this project raises on purpose; `str()` is fit for a user's eyes."""


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


def told(mistakes: Sequence[object], between: str = "\n") -> str:
    """The first ``MOST`` of them, ``between`` one and the next, and how many more there are.

    >>> told(["a is wrong", "b is missing"], "; ")
    'a is wrong; b is missing'
    """
    more = len(mistakes) - MOST
    return between.join([*map(str, mistakes[:MOST]), *([f"and {more} more"] if more > 0 else [])])
