"""A session for Python about an interpretation or a program."""

from pathlib import Path
from typing import Self

from plogic.base.errors import InputError
from plogic.face.python.asking import Asked, opened
from plogic.face.session import session
from plogic.facts.situation import Reading


class Session(session.Session):
    """A session about an interpretation or a program: what is observed stays, and is taken back."""

    def __init__(self, about: Asked, *, rules: str | Path | None = None) -> None:
        """Begin with nothing observed; ``rules``: a file of rules of one's own. Raises Error for anything else."""
        if not isinstance(about, Asked):
            raise InputError(f"a session is about an interpretation or a program, not {about!r:.60}")
        super().__init__(about.beside(rules), limits=about.limits)

    @classmethod
    def open(
        cls,
        path: str | Path,
        *,
        reading: Reading | None = None,
        rules: str | Path | None = None,
        trust: bool = False,
    ) -> Self:
        """Begin a session about an ``interpretation.json`` or a program's file.

        Raises Error where it cannot be read.
        """
        return cls(opened(path, reading, trust=trust), rules=rules)
