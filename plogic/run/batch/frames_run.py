"""A run over frames: who works is asked for lines, and they are written as they come, or in the order of the frames.

``Waiting``: the lines that are done and wait for that of an earlier frame, in a file beside the output, so that a kill
loses none. ``OUT.waiting`` is there as long as any line waits. Each is appended whole as soon as it is done; those that
were written to OUT meanwhile stay in it for a while, and whoever reads it passes over them. Who holds OUT's lock may
write it.
"""

from collections.abc import Callable, Collection, Sequence
from io import FileIO
from pathlib import Path

from geometry.files.plain_files import IS_MISSING, fault_of
from plogic.run.batch.dask import Cluster
from plogic.run.batch.frames import Frame
from plogic.run.batch.log import Log, Written, read_lines
from plogic.run.batch.pool import Answer, Job, Pool
from sensing.errors import SensingError
from sensing.files.whole_files import write_whole

STALE = 512
"""Lines of the file after which it is made anew, of those that still wait."""


class Waiting:
    """Of the run that writes beside ``place``; without a place nothing is kept.

    ``written``: what the file told when this was made.
    """

    def __init__(self, place: Path | None = None) -> None:
        """Changes nothing. Raises InputError where the file holds something else."""
        self._place, self._count = place, 0
        self._file: FileIO | None = None
        self.written: Sequence[Written] = []
        self._lines: list[bytes] = []
        if place is not None and place.is_file():
            self.written, end = read_lines(place, str(place))
            self._lines = [line + b"\n" for line in place.read_bytes()[:end].split(b"\n")[:-1]]

    def found(self, frames: Sequence[Frame]) -> dict[int, tuple[str, bytes]]:
        """Status and line of the frames whose lines waited when this was made, by their place among the frames."""
        known = {
            (told.input, told.frame): (told.status, line) for told, line in zip(self.written, self._lines, strict=True)
        }
        return {
            i: known[frame.input, frame.frame] for i, frame in enumerate(frames) if (frame.input, frame.frame) in known
        }

    def keep(self, line: bytes, held: Collection[bytes]) -> None:
        """One line more waits; ``held`` are all that do, it among them.

        Raises SensingError where it cannot be written.
        """
        if self._place is None:
            return
        self._count += 1
        if self._file is not None and self._count < STALE:
            Log(str(self._place), self._file).write(line)
            return
        self.close()
        write_whole(self._place, b"".join(held))
        self._file, self._count = _appended(self._place), len(held)

    def clear(self) -> None:
        """No line waits any more."""
        self.close()
        if self._place is not None:
            self._place.unlink(missing_ok=True)

    def close(self) -> None:
        """Write no more; what waits stays in the file."""
        if self._file is not None:
            self._file.close()
            self._file = None


def waiting_beside(out: str) -> Path | None:
    """Where lines wait for their turn in OUT; None where that is a stream or a device."""
    path = Path(out)
    return path.with_name(f"{path.name}.waiting") if out != "-" and fault_of(path) in (None, IS_MISSING) else None


def _appended(place: Path) -> FileIO:
    try:
        return place.open("ab", buffering=0)
    except OSError as error:
        raise SensingError(f"{place}: cannot be written: {error.strerror}") from None


AHEAD = 256
"""Frames beyond the first that is still to be written that may be at work, or done and held back: what bounds
memory."""


Engine = Pool | Cluster
"""Who works: the processes of this machine, or a cluster."""


def run(
    frames: Sequence[Frame],
    engine: Engine,
    write: Callable[[Frame, str, bytes], None],
    waiting: Waiting | None = None,
    *,
    in_order: bool,
) -> None:
    """Have every frame perceived, and ``write`` its status and line once.

    In order, those that are done too early are ``waiting`` meanwhile.

    Frames that waited already when an earlier run was killed are written and not perceived again.
    """
    waiting = waiting or Waiting()
    held = {number: Answer(number, *found) for number, found in waiting.found(frames).items()}
    known = frozenset(held)
    given = written = 0

    def take() -> Job | None:
        nonlocal given
        while given in known:
            given += 1
        if given == len(frames) or (in_order and given - written >= AHEAD):
            return None
        given += 1
        return Job(given - 1, frames[given - 1])

    def write_due() -> None:
        nonlocal written
        while held and (not in_order or written in held):
            due = held.pop(written if in_order else next(iter(held)))
            write(frames[due.number], due.status, due.line)
            written += 1
        if not held:
            waiting.clear()

    write_due()
    for answer in engine.answers(take):
        held[answer.number] = answer
        if in_order and answer.number != written:
            waiting.keep(answer.line, [other.line for other in held.values()])
        write_due()
