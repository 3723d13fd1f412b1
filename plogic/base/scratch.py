"""Scratch folders that go when their process does: by itself, or by the next one that makes such a folder.

* ``scratch = Scratch(); scratch.folder / "some.file"; scratch.remove()``
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from pathlib import Path
from time import time

PREFIX = "plogic-child-"
LOCK = ".lock"
"""A file of the folder that is locked as long as somebody uses it."""
YOUNG = 60.0
"""Seconds after which a folder that nobody has locked is left over: its maker may be about to."""


class Scratch:
    """A new folder, which is this process's."""

    def __init__(self) -> None:
        """Sweep what others left, and make the folder."""
        sweep()
        self.folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        self._lock = os.open(self.folder / LOCK, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC)
        fcntl.flock(self._lock, fcntl.LOCK_EX)

    def remove(self) -> None:
        """Remove it with all that is in it."""
        shutil.rmtree(self.folder, ignore_errors=True)
        os.close(self._lock)


def sweep() -> None:
    """Remove the folders of processes that were killed. Whoever has the lock of one is alive."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # another's, or gone meanwhile
            if time() - folder.stat().st_mtime > YOUNG and _is_left(folder):
                shutil.rmtree(folder, ignore_errors=True)


def _is_left(folder: Path) -> bool:
    """Whether nobody has its lock."""
    lock = os.open(folder / LOCK, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    finally:
        os.close(lock)
    return True
