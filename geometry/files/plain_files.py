"""Whether a path leads to a plain file that may be read, whatever the path: a name too long, links in a circle, a pipe that never ends."""

from __future__ import annotations

import errno
import os
import stat
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

IS_MISSING, IS_FOLDER, TOO_LONG = "is missing", "is a folder, not a file", "has a name that is too long for a file"
"""Faults that there are other words for, here and there."""
_WORDS = {
    errno.ENOENT: IS_MISSING,
    errno.ENOTDIR: IS_MISSING,
    errno.ELOOP: "is a link that leads back to itself",
    errno.ENAMETOOLONG: TOO_LONG,
}


def fault_of(path: Path, limit: int | None = None) -> str | None:
    """What forbids to read a file, to be said after its name; None for a plain file of at most ``limit`` bytes. Raises nothing."""
    try:
        found = path.stat()
    except OSError as error:
        return _WORDS.get(error.errno or 0, f"cannot be read: {error.strerror}")
    except ValueError:
        return "has a name that no file can have"
    if stat.S_ISDIR(found.st_mode):
        return IS_FOLDER
    if not stat.S_ISREG(found.st_mode):
        return "is no plain file, but a pipe or a device"
    if not os.access(path, os.R_OK):
        return "cannot be read: Permission denied"
    return (
        f"has {found.st_size} bytes, more than the {limit} that are read"
        if limit is not None and found.st_size > limit
        else None
    )


def is_there(path: Path) -> bool:
    """Whether anything stands at the path, be it a link that leads nowhere. Raises nothing."""
    try:
        path.lstat()
    except (OSError, ValueError):
        return False
    return True
