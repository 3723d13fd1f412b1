"""What was kept and is not used any more: folders named by a key, ``<64 hex digits>``, beside each other in a cache folder.

Which was used last its time of modification says. Whoever has mapped a file of a deleted folder keeps it.

* ``forget_beside(place)``: of the folder's siblings those stay that were used last
* ``forget_files_beside(place)``: so of files ``<64 hex digits>.npz``
"""

from __future__ import annotations

import re
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from time import time

FOLDERS, BYTES = 8, 2 << 30
"""So many folders are kept at most, of so many bytes together; one always is."""
ABANDONED = 86400.0
"""Seconds after which nobody writes any more what was begun."""
FILES = 1024
"""So many files are kept at most, of ``BYTES`` together; one always is."""
_KEY = re.compile("[0-9a-f]{64}")
_FILE, _BEGUN_FILE = re.compile(r"[0-9a-f]{64}\.npz"), re.compile(r"\.[0-9a-f]{64}\.npz\.[a-z0-9_]{8}")
_BEGUN = re.compile(r"\.[0-9a-f]{64}-[a-z0-9_]{8}")


def forget_beside(place: Path, folders: int = FOLDERS, most: int = BYTES) -> None:
    """Delete those siblings of a folder that were used least lately, beyond what is kept; and what was begun and abandoned.

    Nothing else is touched: no file, and no folder of another name.
    """
    try:
        beside = {
            path: path.stat().st_mtime for path in place.parent.iterdir() if path.is_dir() and not path.is_symlink()
        }
    except OSError:  # another process forgets at the same time
        return
    total = 0
    for rank, path in enumerate(
        sorted((path for path in beside if _KEY.fullmatch(path.name)), key=lambda path: (path != place, -beside[path]))
    ):
        total += _bytes(path)
        if rank and (rank >= folders or total > most):
            discard(path)
    for path, written in beside.items():
        if _BEGUN.fullmatch(path.name) and time() - written > ABANDONED:
            shutil.rmtree(path, ignore_errors=True)


def forget_files_beside(place: Path, files: int = FILES, most: int = BYTES) -> None:
    """As ``forget_beside``, of files; no folder and no file of another name is touched."""
    try:
        beside = {path: path.stat() for path in place.parent.iterdir() if path.is_file() and not path.is_symlink()}
    except OSError:  # another process forgets at the same time
        return
    total = 0
    named = (path for path in beside if _FILE.fullmatch(path.name))
    for rank, path in enumerate(sorted(named, key=lambda path: (path != place, -beside[path].st_mtime))):
        total += beside[path].st_size
        if rank and (rank >= files or total > most):
            _unlink(path)
    for path, found in beside.items():
        if _BEGUN_FILE.fullmatch(path.name) and time() - found.st_mtime > ABANDONED:
            _unlink(path)


def _unlink(path: Path) -> None:
    with suppress(OSError):  # another process was first, or nobody may
        path.unlink()


def discard(place: Path) -> None:
    """Delete what is at a place, if anything; it is moved away first, so that nobody finds half of it, and nobody's new one is hit."""
    with suppress(OSError):
        aside = Path(tempfile.mkdtemp(prefix=f".{place.name}-", dir=place.parent))
        try:
            place.rename(aside / place.name)
        finally:
            shutil.rmtree(aside, ignore_errors=True)


def _bytes(folder: Path) -> int:
    try:
        return sum(file.stat().st_size for file in folder.iterdir())
    except OSError:
        return 0
