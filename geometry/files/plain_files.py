"""Whether a path leads to a plain file that may be read, whatever the path.

A name too long, links in a circle, a pipe that never ends.

Files that strangers wrote are read within limits: the bytes or the text, or what is wrong with the file in one line, as
the error that the caller hands in (JSON documents: ``geometry.files.documents``).
"""

import errno
import os
import select
import stat
from collections.abc import Callable
from contextlib import AbstractContextManager
from io import FileIO
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


SILENCE = 600.0
"""Seconds without a byte after which nothing more is expected of a pipe: what writes into it may work for minutes."""
_PIECE = 1 << 20


def content_of(path: Path | str, most: int, error: Callable[[str], Exception]) -> bytes:
    """The bytes of a file, of a pipe or, of '-', of stdin, of at most ``most`` bytes.

    A pipe that says nothing for ``SILENCE`` seconds is given up; a device is never read, but for the terminal.

    Raises:
        error: The file cannot be read, or is larger.
    """
    data = bytearray()
    try:
        with _opened(path) as file:
            found = os.fstat(file.fileno())
            if stat.S_ISREG(found.st_mode) and found.st_size > most:
                raise error(f"{name_of(path)}: has {found.st_size} bytes, more than the {most} that are read")
            if not (stat.S_ISREG(found.st_mode) or _is_pipe(found.st_mode) or file.isatty()):
                raise error(f"{name_of(path)}: {_kind_of(found.st_mode)}")
            while len(data) <= most and (more := _piece(file, path, error, waits=_is_pipe(found.st_mode))):
                data += more
    except OSError as fault:
        raise error(f"{name_of(path)}: cannot be read: {fault.strerror}") from None
    except ValueError:
        raise error(f"{name_of(path)}: has a name that no file can have") from None
    if len(data) > most:
        raise error(f"{name_of(path)}: has more than the {most} bytes that are read")
    return bytes(data)


def _opened(path: Path | str) -> AbstractContextManager[FileIO]:
    """A file, or stdin, of which nothing is read ahead; a pipe that nobody writes to opens, too."""
    if str(path) == "-":
        return FileIO(0, closefd=False)
    return FileIO(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY))


def _is_pipe(mode: int) -> bool:
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


def _kind_of(mode: int) -> str:
    return "cannot be read: Is a directory" if stat.S_ISDIR(mode) else "is a device, not a file"


def _piece(file: FileIO, path: Path | str, error: Callable[[str], Exception], *, waits: bool) -> bytes:
    """The next bytes, none at the end."""
    while True:
        if waits and not select.select([file], [], [], SILENCE)[0]:
            raise error(f"{name_of(path)}: nothing came through this pipe for {SILENCE:g} s")
        more = file.read(_PIECE)
        if more is not None:  # None: another process read first
            return more


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
