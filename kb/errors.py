"""What can go wrong with what can exist.

::

    geometry.errors.PlogicError
    └── KBError                 anything of this package
        ├── TreeError           a tree that breaks A1-A3 or D1-D3; names the node
        ├── SurfaceError        a mesh without facets or extent, or no mesh at all
        ├── CloudError          a learned cloud, or a vocabulary of visual words, that cannot be read
        ├── BusyError           a knowledge base that another process is changing
        ├── IntakeError         a mesh, robot or model file that no type can be made of; names the file
        └── KBErrors            a folder's mistakes, all of them; str() gives a line each, of the first 100
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from geometry.errors import PlogicError, told

NAMED = 3
"""Further places of one mistake that are named."""


class KBError(PlogicError):
    """Anything of this package."""


class TreeError(KBError):
    """A tree of parts that breaks A1-A3 or D1-D3; the message names the node and the rule."""


class SurfaceError(KBError):
    """A mesh that is no closed surface of non-degenerate facets."""


class CloudError(KBError):
    """A learned cloud, or a vocabulary of visual words, that cannot be read."""


class IntakeError(KBError):
    """A mesh, robot or model file that no type can be made of; the message names the file."""


class BusyError(KBError):
    """A knowledge base that another process is changing; the message says which."""


@dataclass(frozen=True, order=True)
class Mistake:
    """One mistake of a KB: ``objects/tower/object.yaml:12:7: parts.1.features.0.type: ...``.

    Lines and columns count from 1.
    """

    file: str
    line: int
    column: int
    path: str
    message: str

    @property
    def place(self) -> str:
        """``objects/tower/object.yaml:12:7``; the file alone where no line is known."""
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file

    def __str__(self) -> str:
        return f"{self.place}: {self.path}: {self.message}" if self.path else f"{self.place}: {self.message}"


class KBErrors(KBError):  # noqa: N818 - the folder's mistakes, in the plural
    """Every mistake of a folder, in the order of files and lines.

    ``str()`` tells the first 100, a line each; one that is made in many places is one line.
    """

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        self.mistakes = tuple(sorted(mistakes))
        super().__init__(told(list(_gathered(self.mistakes))))


def _gathered(mistakes: Sequence[Mistake]) -> Iterator[str]:
    """A line a mistake; one that is made in many places is one line, at the first, with the next ``NAMED`` places.

    It is one where the message and the keys are the same, whatever their numbers in lists.
    """
    groups: dict[tuple[str, ...], list[Mistake]] = {}
    for mistake in mistakes:
        steps = [step for step in mistake.path.split(".") if not step.isdecimal()]
        groups.setdefault((mistake.message, *(steps if mistake.path else [mistake.place])), []).append(mistake)
    for first, *others in groups.values():
        places = [m.place.removeprefix(f"{first.file}:") for m in others[:NAMED]]
        more = f" and {len(others) - NAMED} more places" if len(others) > NAMED else ""
        yield f"{first}; the same at {', '.join(places)}{more}" if others else str(first)
