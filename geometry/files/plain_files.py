"""Whether a path leads to a plain file that may be read, whatever the path.

A name too long, links in a circle, a pipe that never ends.

Files that strangers wrote are read within limits: the bytes, the text or the JSON document, or what is wrong with the
file in one line, as the error that the caller hands in.
"""

import errno
import json
import os
import stat
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import nullcontext
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
    try:
        return content_of(path, most, error).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise error(f"{name_of(path)}: is no {kind}: byte {fault.start} is no UTF-8") from None


def json_of(path: Path | str, most: int, holds: str, error: Callable[[str], Exception], *, finite: bool = False) -> Any:  # noqa: ANN401 - parsed JSON
    """The document of a file, of a pipe or, of '-', of stdin, as ``parsed_json`` has it.

    Raises:
        error: The file cannot be read, is larger than ``most`` bytes, or is no JSON.
    """
    return parsed_json(text_of(path, most, error, "JSON"), name_of(path), holds, error, finite=finite)


def parsed_json(
    text: str, name: str, holds: str, error: Callable[[str], Exception], *, finite: bool = False, single: bool = False
) -> Any:  # noqa: ANN401 - parsed JSON
    """The document that a text is; ``name`` opens the message of an error.

    Args:
        text: JSON.
        name: What errors call the file.
        holds: What should be in it, said where it is nested too deeply.
        error: What is raised.
        finite: NaN and infinities are refused, as JSON has none.
        single: Keys that stand twice in one object are refused, a line each.

    Raises:
        error: It is no JSON, or is refused.
    """

    def refuse(constant: str) -> float:
        raise error(f"{name}: is no JSON: {constant} is no number")

    doubled: list[str] = []

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(items)
        if len(found) < len(items):
            doubled.extend(sorted(key for key, times in Counter(key for key, _ in items).items() if times > 1))
        return found

    try:
        document = json.loads(
            text, parse_constant=refuse if finite else None, object_pairs_hook=pairs if single else None
        )
    except json.JSONDecodeError as fault:
        raise error(f"{name}:{fault.lineno}:{fault.colno}: is no JSON: {fault.msg}") from None
    except RecursionError:
        raise error(f"{name}: is nested too deeply: {holds}") from None
    except ValueError:  # json's own is above
        raise error(f"{name}: holds a whole number of more digits than can be read") from None
    if doubled:
        raise error("\n".join(f"{name}: the key {key!r} is given twice in one object" for key in doubled))
    return document
