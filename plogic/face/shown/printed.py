r"""Where the command line prints: no other module under it writes to the standard streams.

* ``emit("P = 0.5")``: for people, or JSON, on stdout; what cannot be printed is escaped, as what the locale has not is
* ``hand_over("0.5::a.")``: a text that is read again, on stdout: UTF-8, nothing changed
* ``say("wrote x.json")``: a message on stderr, escaped and cut
* ``over("cup: 20 of 120 views")``: the line of a terminal that is written over
* ``open_streams()``: from then on whatever is printed past these (by click, as a warning, by a log) is escaped as well

A disk that is full, or a stream that is closed, ends the command with one line where results are lost. What cannot be
said on stderr is not said, and the command goes on: its result does not depend on it.
"""

import codecs
import io
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

from geometry.diverted import DIVERTED
from geometry.printable import escape, fit, shown, visible
from plogic.base.errors import OutputError, ReaderGoneError


def _in_place_of(error: UnicodeError) -> tuple[str, int]:
    """What an encoding has not as JSON writes it; the rule under a table's head as a plain one."""
    assert isinstance(error, UnicodeEncodeError)  # noqa: S101 - nothing is decoded with it
    signs = error.object[error.start : error.end]
    return "".join("-" if sign == "─" else escape(sign) for sign in signs), error.end


_ESCAPED = "plogic-escaped"
codecs.register_error(_ESCAPED, _in_place_of)
_EMPHASIS = re.compile("(\x1b\\[[0-3](?:;[0-3])*m)")
"""Bold, dim and italic, and their end: of our tables, on a terminal."""


def emit(text: str) -> None:
    """Write a text for people, or JSON, to stdout, with an end of line."""
    pieces = _EMPHASIS.split(text) if sys.stdout.isatty() else [text]
    _put(sys.stdout, _ended("".join(piece if i % 2 else shown(piece) for i, piece in enumerate(pieces))))


def hand_over(text: str) -> None:
    """Write a text that is read again to stdout, as it would stand in a file."""
    _put(sys.stdout, _ended(text), "utf-8")


def say(text: str) -> None:
    """Write a message to stderr, a line or a few."""
    _put(sys.stderr, _ended(fit(text.removesuffix("\n"))))


def over(text: str) -> None:
    """Write over the line of a terminal, on stderr; '' takes it away."""
    width = shutil.get_terminal_size().columns - 1  # what wraps is not written over
    _put(sys.stderr, f"\r{visible(text)[:width]}\033[K")


def written(text: str, place: str, *, say: Callable[[str], None], write: Callable[[str], None]) -> None:
    """Write a text into a file, whole or not at all, and say so; where the place is ``-``, hand it to ``write``."""
    from sensing.files.whole_files import write_whole

    if place == "-":
        write(text)
        return
    write_whole(Path(place), text.encode())
    say(f"wrote {place}")


def open_streams() -> None:
    """Put ``Screen`` in the place of stdout and stderr, and something in that of streams which are closed.

    Else the next file that is opened would get the number of a closed stream, and what is printed. Reading a closed
    stdin finds nothing; writing to a closed stdout fails, to a closed stderr does not.
    """
    for number, flags in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, flags)  # gets the lowest number that is free
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", errors="surrogateescape")  # noqa: SIM115 - as long as the process
    elif isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(encoding="utf-8", errors="surrogateescape")  # names of files, of whatever bytes
    sys.stdout, sys.stderr = Screen(sys.stdout, 1), Screen(sys.stderr, 2)


def tell_unkept() -> None:
    """Say that loops were compiled which the next run compiles again."""
    loops = sys.modules.get("sensing.compiled")
    if loops is not None and loops.UNKEPT:
        say(
            f"{len(loops.UNKEPT)} loops were compiled for this run alone, as no folder takes them: set NUMBA_CACHE_DIR"
            " to one that can be written to"
        )


def let_go() -> None:
    """Leave what could not be written to stdout: Python, which would try again at its end, has nothing to tell."""
    try:
        sys.stdout.flush()
    except OSError:
        _drop(sys.stdout)


class Screen(io.TextIOWrapper):
    """A standard stream: whatever is written is escaped, and there at once."""

    def __init__(self, stream: TextIO | None, number: int) -> None:
        """``stream``: what stood there, which is of no use any more; None where it was closed."""
        self.charset = "utf-8" if stream is None else stream.encoding
        plain = codecs.lookup(self.charset).name == "ascii"  # click writes past a stream that says so
        buffer = open(number, "wb") if stream is None else stream.detach()  # type: ignore[attr-defined]  # noqa: SIM115
        if isinstance(buffer, io.RawIOBase):  # PYTHONUNBUFFERED: it may write a part
            buffer = io.BufferedWriter(buffer)
        super().__init__(buffer, encoding="utf-8" if plain else self.charset, errors=_ESCAPED, newline="\n")

    def write(self, text: str) -> int:
        """Write what others print."""
        _put(self, shown(text))
        return len(text)


def _drop(stream: TextIO) -> None:
    """Let what is left over, and whatever is written from now on, go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _ended(text: str) -> str:
    return text if text.endswith("\n") else text + "\n"


def _put(stream: TextIO, text: str, charset: str = "") -> None:
    """Write all of it now.

    Raises:
        OutputError: It cannot be written; not of stderr.
        ReaderGoneError: Nobody reads stdout any more.
    """
    if not text:  # click tries what a stream takes, and passes over what that raises
        return
    data = text.encode(charset or getattr(stream, "charset", stream.encoding) or "utf-8", _ESCAPED)
    try:
        if isinstance(stream, io.StringIO):  # somebody's own, in the place of a stream
            stream.write(data.decode())
            return
        with DIVERTED:
            stream.flush()
            stream.buffer.write(data)
            stream.buffer.flush()
    except OSError as error:
        _drop(stream)
        if stream is sys.stderr:
            return
        if isinstance(error, BrokenPipeError):
            raise ReaderGoneError from None
        raise OutputError(f"standard output: cannot be written: {error.strerror}") from None
