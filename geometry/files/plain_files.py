"""Whether a path leads to a plain file that may be read, whatever the path: a name too long, links in a circle, a pipe that never ends.

JSON files that strangers wrote: the document, or what is wrong with the file in one line, whatever it holds.
"""

import errno
import json
import os
import stat
import sys
from pathlib import Path
from typing import Any

IS_MISSING, IS_FOLDER, TOO_LONG = "is missing", "is a folder, not a file", "has a name that is too long for a file"
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


class JsonError(Exception):
    """What is wrong with a JSON file, after its name, and the line and column where they are known."""


def json_of(path: Path | str, most: int, holds: str, *, finite: bool = False) -> Any:  # noqa: ANN401 - parsed JSON
    """The document of a file, of a pipe or, of '-', of stdin, of at most ``most`` bytes.

    ``holds`` says what should be in it where it is nested too deeply; ``finite``: NaN and infinities are refused, as
    JSON has none.

    Raises:
        JsonError: The file cannot be read, or is no JSON.
    """
    path = "<stdin>" if (piped := str(path) == "-") else path

    def refuse(constant: str) -> float:
        raise JsonError(f"{path}: is no JSON: {constant} is no number")

    try:
        data = sys.stdin.buffer.read(most + 1) if piped else _head(Path(path), most + 1)
        if len(data) > most:
            raise JsonError(f"{path}: is larger than the {most} bytes that are read")
        return json.loads(data.decode("utf-8-sig"), parse_constant=refuse if finite else None)
    except json.JSONDecodeError as error:
        raise JsonError(f"{path}:{error.lineno}:{error.colno}: is no JSON: {error.msg}") from None
    except UnicodeDecodeError as error:
        raise JsonError(f"{path}: is no JSON: byte {error.start} is no UTF-8") from None
    except RecursionError:
        raise JsonError(f"{path}: is nested too deeply: {holds}") from None
    except ValueError:  # json's own is above
        raise JsonError(f"{path}: holds a whole number of more digits than can be read") from None
    except OSError as error:
        raise JsonError(f"{path}: cannot be read: {error.strerror}") from None


def _head(path: Path, most: int) -> bytes:
    with path.open("rb") as file:
        return file.read(most)
