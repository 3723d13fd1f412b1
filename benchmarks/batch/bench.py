"""``plogic bench batch``: a thousand frames one at a time, by two processes, by a Dask cluster, and killed and resumed.

The interpretations must be the same bytes as those of ``plogic perceive``, and two processes must be nearly twice as
fast as one.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

from benchmarks.shared.claims import Claim, report
from benchmarks.shared.processor import processor_seconds
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Say = Callable[[str], None]

FRAMES, TIMED = 1000, 200
"""Frames in all, and as many of them as the pairs of runs take that are timed."""
FEW, FEW_TIMED = 60, 60
"""The same where it is to be quick."""
PAIRS = 3
KB = "towers"


@dataclass(frozen=True)
class Done:
    """One run: what was run, on how many frames, in how many seconds of the clock and of processors, and its lines.

    Seconds of processors are those of this process and its own children, so of Dask's and of killed workers there are
    none.
    """

    name: str
    frames: int
    seconds: float
    processor: float
    lines: list[bytes]


class Clocks:
    """The clock on the wall and that of the processors, since it was made."""

    def __init__(self) -> None:
        self._start = perf_counter(), processor_seconds()

    def read(self) -> tuple[float, float]:
        """Seconds of both."""
        return perf_counter() - self._start[0], processor_seconds() - self._start[1]


def run(*, seed: int, quick: bool = False, as_json: bool = False, say: Say, **_: object) -> tuple[str, bool]:
    """Run the benchmark. Raises InputError where a run fails."""
    from benchmarks.batch.frames import write_frames
    from plogic.run.sources import kb_of

    total, timed = (FEW, FEW_TIMED) if quick else (FRAMES, TIMED)
    with tempfile.TemporaryDirectory(prefix="plogic-batch-") as place:
        folder = Path(place)
        write_frames(kb_of(KB), total, seed, folder / "frames", say)
        some = "".join(f"{path}\n" for path in sorted((folder / "frames").iterdir())[:timed])
        (folder / "some.txt").write_text(some, encoding="utf-8")
        alone = one_at_a_time(folder, say)
        whole = [whole_run(folder, "two processes", ["--jobs", "2"], say), killed_and_resumed(folder, total // 2, say)]
        whole += by_dask(folder, say)
        pairs = [(timed_run(folder, 1, i, timed, say), timed_run(folder, 2, i, timed, say)) for i in range(PAIRS)]
        rows = [_row(done) for done in (alone, *whole, *(done for pair in pairs for done in pair))]
        return report("batch", rows, _claims(alone, whole, pairs), as_json=as_json)


def one_at_a_time(folder: Path, say: Say) -> Done:
    """Each frame by what ``plogic perceive`` runs, in this process; its ``lines`` are the interpretations."""
    from plogic.face.commands.perceive import perceive_command
    from plogic.face.shown.options import Perceiving
    from plogic.run.batch.frames import frames_of
    from plogic.run.cameras import GivenCamera, camera_beside

    clocks, texts = Clocks(), list[str]()
    frames = frames_of([str(folder / "frames")], ())
    for i, frame in enumerate(frames, 1):
        options = Perceiving(KB, camera=camera_beside(frame.input, GivenCamera()))
        perceive_command([frame.input], options, say=lambda _: None, write=texts.append)
        if i % 100 == 0:
            say(f"one at a time: {i} of {len(frames)}")
    return Done("perceive, one at a time", len(frames), *clocks.read(), [text.encode() for text in texts])


def whole_run(folder: Path, name: str, options: Sequence[str], say: Say) -> Done:
    """All frames, whole interpretations."""
    clocks = Clocks()
    _finish(_started(folder, "whole.jsonl", [*options, "--full", str(folder / "frames")]))
    return _done(folder, name, "whole.jsonl", clocks, say)


def killed_and_resumed(folder: Path, middle: int, say: Say) -> Done:
    """All frames, with everything killed once ``middle`` lines are there, and gone on with."""
    clocks, out = Clocks(), folder / "killed.jsonl"
    options = ["--jobs", "2", "--full", str(folder / "frames")]
    first = _started(folder, out.name, options)
    while first.poll() is None and (not out.exists() or out.read_bytes().count(b"\n") < middle):
        sleep(0.5)
    if first.poll() is not None:
        raise InputError("the run that was to be killed ended before")
    os.killpg(first.pid, signal.SIGKILL)
    first.communicate()
    say(f"killed when there were at least {middle} lines")
    _finish(_started(folder, out.name, [*options, "--resume"]))
    return _done(folder, "killed and resumed", out.name, clocks, say)


def by_dask(folder: Path, say: Say) -> list[Done]:
    """All frames by a scheduler and two workers; nothing where the package is absent."""
    from importlib.util import find_spec

    if find_spec("distributed") is None:
        say("Dask is not tried: the package distributed is absent")
        return []
    from benchmarks.batch.cluster import loopback

    with loopback(2) as address:
        return [whole_run(folder, "Dask, two workers", ["--dask", address], say)]


def timed_run(folder: Path, jobs: int, number: int, frames: int, say: Say) -> Done:
    """Some frames, lines as users get them by default; from the start of the command to its end."""
    clocks = Clocks()
    _finish(_started(folder, "timed.jsonl", ["--jobs", str(jobs), "-"], (folder / "some.txt").read_bytes()))
    done = _done(folder, f"pair {number + 1}, jobs {jobs}", "timed.jsonl", clocks, say)
    if done.frames != frames:
        raise InputError(f"{done.name}: {done.frames} lines of {frames}")
    return done


def _started(folder: Path, out: str, options: Sequence[str], listed: bytes = b"") -> subprocess.Popen[bytes]:
    """``plogic batch`` in a process group of its own."""
    command = [sys.executable, "-m", "cli", "batch", "--kb", KB, "-o", out, *options]
    with tempfile.TemporaryFile() as stdin:
        stdin.write(listed)
        stdin.seek(0)
        return subprocess.Popen(command, cwd=folder, stdin=stdin, stderr=subprocess.PIPE, start_new_session=True)  # noqa: S603 - ourselves


def _finish(child: subprocess.Popen[bytes]) -> None:
    said = child.communicate()[1]
    if child.returncode:
        raise InputError(
            f"plogic batch failed with exit status {child.returncode}: {said.decode(errors='replace').strip()}"
        )


def _done(folder: Path, name: str, out: str, clocks: Clocks, say: Say) -> Done:
    seconds, processor = clocks.read()
    lines = (folder / out).read_bytes().splitlines(keepends=True)
    (folder / out).unlink()
    say(f"{name}: {len(lines)} frames, {seconds:.1f} s")
    return Done(name, len(lines), seconds, processor, lines)


def differing(alone: Sequence[bytes], lines: Sequence[bytes]) -> int:
    """Lines that differ from the interpretation that ``plogic perceive`` wrote, and lines too many or too few."""
    ends = (b'"interpretation":' + text.removesuffix(b"\n") + b"}\n" for text in alone)
    return abs(len(alone) - len(lines)) + sum(not line.endswith(end) for end, line in zip(ends, lines, strict=False))


def _claims(alone: Done, whole: Sequence[Done], pairs: Sequence[tuple[Done, Done]]) -> list[Claim]:
    same = [
        Claim(f"{done.name}: frames that are not the bytes of `perceive`", "<=", 0, differing(alone.lines, done.lines))
        for done in whole
    ]
    others = sum(a.lines != b.lines for a, b in pairs)
    faster = median([one.seconds / two.seconds for one, two in pairs])
    return [
        *same,
        Claim("pairs in which one process and two write different bytes", "<=", 0, others),
        Claim("two processes against one, frames in the same time, median of the pairs", ">=", 1.7, faster),
    ]


def _row(done: Done) -> dict[str, Any]:
    times = {"seconds": round(done.seconds, 1), "of processors": round(done.processor, 1)}
    return {"run": done.name, "frames": done.frames, **times, "frames a second": round(done.frames / done.seconds, 2)}
