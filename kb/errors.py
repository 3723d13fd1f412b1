"""What can go wrong with what can exist.

::

    geometry.errors.PlogicError
    └── KBError                 anything of this package
        ├── TreeError           a tree that breaks A1-A3 or D1-D3; names the node
        ├── SurfaceError        a mesh without facets or extent, or no mesh at all
        ├── CloudError          a learned cloud, or a vocabulary of visual words, that cannot be read
        ├── IntakeError         a mesh, robot or model file that no type can be made of; names the file
        └── KBErrors            a folder's mistakes, all of them; str() gives a line each, of the first 100
"""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry.errors import PlogicError, told


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

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        return f"{where}: {self.path}: {self.message}" if self.path else f"{where}: {self.message}"


class KBErrors(KBError):  # noqa: N818 - the folder's mistakes, in the plural
    """Every mistake of a folder, in the order of files and lines; ``str()`` tells the first 100."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        self.mistakes = tuple(sorted(mistakes))
        super().__init__(told(self.mistakes))
