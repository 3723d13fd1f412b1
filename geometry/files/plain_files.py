"""Whether a path leads to a plain file that may be read, whatever the path.

A name too long, links in a circle, a pipe that never ends.

Files that strangers wrote are read within limits: the bytes or the text, or what is wrong with the file in one line, as
the error that the caller hands in (JSON documents: ``geometry.files.documents``).
"""

import errno
import os
import stat
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

IS_MISSING, IS_FOLDER, TOO_LONG = "is missing", "is a folder, not a file", "has a name that is too long for a file"
NO_PLAIN_FILE = "is no plain file, but a pipe or a device"
"""Faults that there are other words for, here and there."""
_WORDS = {
    errno.ENOENT: IS_MISSING,
    errno.ENOTDIR: IS_MISSING,
    errno.ELOOP: "is a link that leads back to itself",
    errno.ENAMETOOLONG: TOO_LONG,
}


def fault_of(path: Path, limit: int | None = None) -> str | None:
    """What forbids to read a file, to be said after its name; None for a plain file of at most ``limit`` bytes.

    Raises nothing.
    """
    try:
        found = path.stat()
    except OSError as error:
        return _WORDS.get(error.errno or 0, f"cannot be read: {error.strerror}")
    except ValueError:
        return "has a name that no file can have"
    if stat.S_ISDIR(found.st_mode):
        return IS_FOLDER
    if not stat.S_ISREG(found.st_mode):
        return NO_PLAIN_FILE
    if not os.access(path, os.R_OK):
        return "cannot be read: Permission denied"
    return (
        f"has {found.st_size} bytes, more than the {limit} that are read"
        if limit is not None and found.st_size > limit
        else None
    )


def must_be_plain(path: Path | str, error: Callable[[str], Exception], limit: int | None = None) -> None:
    """Raise ``error`` that names a file and says what forbids to read it.

    Nothing for a plain file of at most ``limit`` bytes.
    """
    fault = fault_of(Path(path), limit)
    if fault is not None:
        raise error(f"{path}: {fault}")


def is_there(path: Path) -> bool:
    """Whether anything stands at the path, be it a link that leads nowhere. Raises nothing."""
    try:
        path.lstat()
    except (OSError, ValueError):
        return False
    return True


def content_of(path: Path | str, most: int, error: Callable[[str], Exception]) -> bytes:
    """The bytes of a file, of a pipe or, of '-', of stdin, of at most ``most`` bytes.

    Raises:
        error: The file cannot be read, or is larger.
    """
    try:
        with nullcontext(sys.stdin.buffer) if str(path) == "-" else Path(path).open("rb") as file:
            data = bytearray()
            while len(data) <= most and (more := file.read(1 << 20)):
                data += more
    except OSError as fault:
        raise error(f"{path}: cannot be read: {fault.strerror}") from None
    if len(data) > most:
        raise error(f"{name_of(path)}: is larger than the {most} bytes that are read")
    return bytes(data)


def name_of(path: Path | str) -> str:
    """What errors call a file: ``<stdin>`` for '-'."""
    return "<stdin>" if str(path) == "-" else str(path)


def text_of(path: Path | str, most: int, error: Callable[[str], Exception], kind: str = "text") -> str:
    """As ``content_of``, the text; ``kind`` is what the file is not where its bytes are no UTF-8."""
    content = content_of(path, most, error)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line, column = content.count(b"\n", 0, fault.start) + 1, fault.start - content.rfind(b"\n", 0, fault.start)
        where = f"{name_of(path)}:{line}:{column}"
        raise error(f"{where}: is no {kind}: byte {fault.start} is no UTF-8") from None
