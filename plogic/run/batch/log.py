"""The file that lines are appended to, each whole and at once, so that a run that was killed can go on with it."""

import fcntl
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import RawIOBase
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from geometry.files.begun import swept_once
from plogic.base.errors import InputError, ReaderGoneError
from plogic.run.batch.frame_lines import DONE, ERROR, FORMAT, UNFINISHED
from plogic.run.batch.frames import Frame, Settings, digest_of
from sensing.errors import SensingError
from sensing.files.whole_files import check_places

HEAD = f'{{"format":"{FORMAT}",'.encode()
"""How every line begins."""
MOST = 10
"""Mistakes of a file that are told; no more are looked for."""
TAKE_OUT = "take these lines out and go on with --order done, or start a new file"
KEYS: dict[str, Callable[[Any], bool]] = {
    "input": lambda value: isinstance(value, str),
    "frame": lambda value: value is None or isinstance(value, str),
    "status": lambda value: isinstance(value, str) and value in {DONE, UNFINISHED, ERROR},
    "sha256": lambda value: value is None or isinstance(value, str),
    "kb": lambda value: isinstance(value, dict),
    "options": lambda value: isinstance(value, dict),
}
"""What a line tells of its frame, and whether a value may be it."""


class Written(NamedTuple):
    """What a line that is there already tells of its frame; ``place`` is the file and its number."""

    place: str
    input: str
    frame: str | None
    status: str
    sha256: str | None
    kb: Mapping[str, str]
    options: Mapping[str, Any]

    @property
    def name(self) -> str:
        """As people are told."""
        return self.input if self.frame is None else f"{self.input} {self.frame}"


class Mistakes:
    """What is wrong with a file's lines, told at once, and what is to be done about it."""

    def __init__(self, remedy: str) -> None:
        self._lines, self._remedy = list[str](), remedy

    def add(self, line: str) -> None:
        """One more; raises InputError where there are so many that no more are to be looked for."""
        self._lines.append(line)
        if len(self._lines) == MOST:
            self._lines.append("there may be more")
            self.check()

    def check(self) -> None:
        """Raise InputError where there is any."""
        if self._lines:
            raise InputError("\n".join([*self._lines, f"--resume cannot go on: {self._remedy}"]))


class Log:
    """Where lines go: standard output, or a file; ``written``: what the lines tell that it holds already."""

    def __init__(
        self, name: str, file: BinaryIO | RawIOBase, written: Sequence[Written] = (), end: int | None = None
    ) -> None:
        """``end``: the bytes of what is written; None where nothing can be cut."""
        self._name, self._file, self.written, self._end = name, file, written, end

    def cut(self) -> None:
        """Take away the torn line that follows those that are written."""
        if self._end is not None:
            self._file.truncate(self._end)

    def write(self, line: bytes) -> None:
        """Append one line, or raise SensingError, or of a pipe without a reader ReaderGoneError."""
        left = memoryview(line)
        try:
            while left:
                left = left[self._file.write(left) :]
            self._file.flush()
        except BrokenPipeError:
            raise ReaderGoneError from None
        except OSError as error:
            raise SensingError(f"{self._name}: cannot be written: {error.strerror}") from None


def check_out(places: Iterable[Path], *, resume: bool) -> None:
    """Before any work, raise InputError where a file is full without ``resume``, SensingError where none can be."""
    for path in places:
        check_places([path])
        _check_empty(path, resume=resume)


def _check_empty(path: Path, *, resume: bool) -> None:
    if not resume and path.is_file() and path.stat().st_size:
        raise InputError(f"{path}: is there already: --resume goes on with it; else remove it, or name another")


@contextmanager
def log_at(out: str, *, resume: bool = True) -> Iterator[Log]:
    """Standard output for ``-``; else the file, with the lines that it holds already, which ``resume`` allows.

    Raises:
        InputError: Another run is writing, or has written since ``check_out``, or what is there are no such lines.
        SensingError: It cannot be written.
    """
    if out == "-":
        yield Log("standard output", sys.stdout.buffer)
        return
    path = Path(out)
    try:
        file = path.open("a+b", buffering=0)
    except OSError as error:
        raise SensingError(f"{out}: cannot be written: {error.strerror}") from None
    with file:
        if not path.is_file():  # a device
            yield Log(out, file)
            return
        _lock(file, out)
        _check_empty(path, resume=resume)
        swept_once(path.parent)
        yield Log(out, file, *read_lines(path, out))
        os.fsync(file)


def _lock(file: RawIOBase, out: str) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise InputError(f"{out}: another run is writing it") from None


def read_lines(path: Path, out: str) -> tuple[list[Written], int]:
    """What the lines of a file tell, and how many bytes they are; what follows the last end of a line is a torn one.

    Raises InputError.
    """
    written: list[Written] = []
    end = 0
    wrong = Mistakes(TAKE_OUT)
    with path.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            if not line.endswith(b"\n"):
                if line[: len(HEAD)] != HEAD[: len(line)]:
                    wrong.add(f"{out}:{number}: is no {FORMAT}, so that it cannot be gone on with")
                break
            told = _told(line, f"{out}:{number}", wrong)
            if told is not None:
                written.append(
                    told._replace(kb=written[-1].kb, options=written[-1].options)
                    if written and _alike(told, written[-1])
                    else told
                )
            end += len(line)
    wrong.check()
    return written, end


def _alike(a: Written, b: Written) -> bool:
    """Whether two lines may share what a million of them would else each hold for itself."""
    return a.kb == b.kb and a.options == b.options


def _told(line: bytes, place: str, wrong: Mistakes) -> Written | None:
    try:
        document = json.loads(line)
        if document["format"] == FORMAT:
            keys = [key for key, right in KEYS.items() if not right(document[key])]
            if not keys:
                return Written(place, *(document[key] for key in KEYS))
            wrong.add(
                f"{place}: is no {FORMAT}: {', '.join(keys)}: {'is' if len(keys) == 1 else 'are'} of another kind"
            )
            return None
    except (ValueError, TypeError, KeyError, RecursionError):
        pass
    wrong.add(f"{place}: is no {FORMAT}, so that it cannot be gone on with")
    return None


def left_over(frames: Sequence[Frame], written: Sequence[Written], *, in_order: bool) -> list[Frame]:
    """The frames that have no line yet.

    Raises:
        InputError: A line is of no frame that was named, or of one twice; or the lines are not in the order of the
        frames, and should be.
    """
    place = {(frame.input, frame.frame): i for i, frame in enumerate(frames)}
    seen: set[int] = set()
    wrong = Mistakes(f"name the inputs as they were named; else {TAKE_OUT}")
    for line in written:
        i = place.get((line.input, line.frame))
        if i is None:
            wrong.add(f"{line.place}: is of {line.name}, which is not among the inputs now")
        elif i in seen:
            wrong.add(f"{line.place}: is of {line.name}, as an earlier one is")
        else:
            seen.add(i)
    wrong.check()
    for number, line in enumerate(written if in_order else ()):
        i = place[line.input, line.frame]
        if i != number:
            raise InputError(
                f"{line.place}: is of {line.name}, which is number {i + 1} of the inputs: to go on out of order, give --order done"
            )
    return [frame for i, frame in enumerate(frames) if i not in seen]


def check_same(frames: Sequence[Frame], written: Sequence[Written], settings: Settings, kb: Mapping[str, str]) -> None:
    """Raise InputError where lines were made with another KB, by other options, or of frames of other content."""
    wrong = Mistakes("give the knowledge base and the options of then; else start a new file")
    options = settings.document()
    for line in written:
        if line.kb != kb:
            wrong.add(
                f"{line.place}: was made with another knowledge base: {settings.kb} has changed since, or is another"
            )
        elif line.options != options:
            told = {
                key: line.options.get(key, "none")
                for key in {**line.options, **options}
                if line.options.get(key) != options.get(key)
            }
            wrong.add(
                f"{line.place}: was made by other options: {', '.join(f'{key} {value}' for key, value in told.items())}"
            )
    wrong.check()
    wrong = Mistakes(TAKE_OUT)
    known = {(frame.input, frame.frame): frame for frame in frames}
    for line in written:
        frame = known[line.input, line.frame]
        if digest_of(frame, settings.camera) == line.sha256:
            continue
        if line.sha256 is not None and digest_of(frame, settings.camera, nested=True) == line.sha256:
            wrong.add(f"{line.place}: was written by an earlier plogic, whose sha256 is of each file's own sha256")
        else:
            wrong.add(f"{line.place}: {line.name} or its camera has changed since it was written")
    wrong.check()
