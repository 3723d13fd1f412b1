"""The lines of earlier sessions, in the user's folder for such things; where it cannot be written, that is said once."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from prompt_toolkit.history import FileHistory

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


def history_file() -> Path:
    """``$XDG_STATE_HOME/plogic/history``, or ``~/.local/state/plogic/history`` where that is not set or is no absolute path."""
    state = os.environ.get("XDG_STATE_HOME", "")
    return (Path(state) if Path(state).is_absolute() else Path.home() / ".local" / "state") / "plogic" / "history"


class History(FileHistory):
    """As prompt_toolkit's, but a file that cannot be read or written costs a sentence and no session."""

    def __init__(self, path: Path, say: Callable[[str], None]) -> None:
        self.say, self.told = say, False
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            self.tell(error)
        super().__init__(str(path))

    def load_history_strings(self) -> Iterable[str]:
        """The lines, newest first; none where they cannot be read."""
        try:
            return list(super().load_history_strings())
        except OSError as error:
            self.tell(error)
            return []

    def store_string(self, string: str) -> None:
        """Append a line, if that can be done."""
        try:
            super().store_string(string)
        except OSError as error:
            self.tell(error)

    def tell(self, error: OSError) -> None:
        """Say it, the first time."""
        if not self.told:
            self.told = True
            self.say(f"the history cannot be kept: {error.filename}: {error.strerror}")
