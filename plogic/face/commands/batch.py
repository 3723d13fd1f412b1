"""``plogic batch``: many frames, one line of JSON each, by several processes or a Dask cluster."""

import json
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from shlex import quote
from time import monotonic

from geometry.errors import WhichCameraError
from geometry.printable import on_one_line, visible
from plogic.base.alarm import TICK, alarmed
from plogic.base.children import ending_well
from plogic.base.errors import ReaderGoneError
from plogic.face.shown.options import Batching
from plogic.face.shown.printed import say
from plogic.face.shown.progress import SELDOM, WIDTH, Progress, Say, bar, beating, duration, so_far
from plogic.run.batch.frame_lines import ERROR, UNFINISHED, doubt_in, is_empty, is_noted
from plogic.run.batch.frames import Frame, Settings, checked, frames_of
from plogic.run.batch.frames_run import Engine, Waiting, run, waiting_beside
from plogic.run.batch.log import Log, check_out, check_same, left_over, log_at
from plogic.run.batch.pool import AtWork, Pool
from plogic.run.batch.work import check_cameras
from plogic.run.cameras import GivenCamera, read_given

NOTED = "noted"
"""What is counted beside bad and unfinished frames."""
SOME_SIZE = 640, 480
"""Of a picture that is not read yet, where the camera's file states no size."""
BAD, LATE = 1, 3
"""Exit statuses: a frame could not be perceived; the deadline cut one short."""


def batch_command(inputs: Sequence[str], settings: Settings, options: Batching, *, listed: Iterable[str]) -> int:
    """Find the frames, start who works, write the lines; returns the exit status.

    ``listed``: what ``-`` among the inputs stands for.

    Raises:
        PlogicError: What is wrong with inputs, KB or file before any work; nothing is written then.
    """
    out = options.out
    beside = waiting_beside(out)
    check_out([] if out == "-" else [Path(out), *([beside] if beside is not None else [])], resume=options.resume)
    _check_camera(settings.camera)
    frames = frames_of(inputs, listed, options.every)
    check_cameras(frames, settings.camera)
    with ending_well(), ExitStack() as stack:
        with beating(lambda: f"reading {settings.kb}") as above:
            engine = _engine(settings, options, above(say))
            stack.callback(engine.close)
            engine.start(len(frames))
            kb = engine.kb()
        with log_at(out, resume=options.resume) as log, closing(Waiting(beside)) as waiting:
            return _run(frames, engine, log, waiting, settings, kb, out, in_order=options.order == "input")


def _check_camera(given: GivenCamera) -> None:
    """Raise InputError or CameraError where every picture would say what is wrong with the camera's file."""
    if (source := given.source()) is not None and given.file is not None:
        checked(source)
        with suppress(WhichCameraError):  # each picture tells its own
            read_given(given.file, SOME_SIZE)


def _engine(settings: Settings, options: Batching, say: Say) -> Engine:
    if options.dask is not None:
        from plogic.run.batch.dask import Cluster

        return Cluster(settings, str(Path.cwd()), options.dask, options.timeout, say)
    return Pool(settings, str(Path.cwd()), options.jobs or len(os.sched_getaffinity(0)), options.timeout)


def _run(
    frames: Sequence[Frame],
    engine: Engine,
    log: Log,
    waiting: Waiting,
    settings: Settings,
    kb: dict[str, str],
    out: str,
    *,
    in_order: bool,
) -> int:
    left = left_over(frames, log.written, in_order=in_order)
    left_over(frames, waiting.written, in_order=False)
    check_same(frames, [*log.written, *waiting.written], settings, kb)
    log.cut()
    count = {status: sum(line.status == status for line in log.written) for status in (ERROR, UNFINISHED)}
    count[NOTED] = 0
    before = {(line.input, line.frame) for line in (*log.written, *waiting.written)}
    progress = Frames(len(frames), len(frames) - len(before), engine.at_work)
    empty, doubted = list[Frame](), list[Frame]()

    def write(frame: Frame, status: str, line: bytes) -> None:
        log.write(line)
        if status in count:
            count[status] += 1
        if status == ERROR:
            progress.say(_why(frame, line))
        if not doubted and (doubt := doubt_in(line)):
            doubted.append(frame)
            progress.say(f"{frame.name}: {doubt} (told once)")
        count[NOTED] += is_noted(line)
        empty.extend([frame] * is_empty(line))
        if (frame.input, frame.frame) not in before:
            progress.step(bad=status == ERROR)

    try:
        with alarmed(progress.tick, TICK, TICK):
            run(left, engine, write, waiting, in_order=in_order)
    except ReaderGoneError:
        progress.end()
        raise
    except BaseException:
        progress.end()
        progress.say(f"stopped; --resume goes on with {out}" if out != "-" else "stopped")
        raise
    progress.end()
    if empty:
        progress.say(_told_of(empty))
    progress.say(_summary(out, len(frames), len(frames) - len(before), count))
    return BAD if count[ERROR] else LATE if count[UNFINISHED] else 0


def _why(frame: Frame, line: bytes) -> str:
    """The error of a line: its first mistake and their number, after the frame's name unless it says that itself."""
    error = on_one_line(str(json.loads(line)["error"]), [frame.input])
    first, *others = error.splitlines() or [""]
    named = first if first.startswith(visible(frame.input)) else f"{visible(frame.name)}: {first}"
    return named + (f" (and {len(others)} more)" if others else "")


def _told_of(empty: Sequence[Frame]) -> str:
    """How many frames have nothing in them, and where to ask why; a frame of a video or a dataset has no file."""
    first = min(empty, key=lambda frame: frame.name)
    ask = (
        f" (plogic perceive {quote(first.input)}, with the same KB and camera, tells why)"
        if first.frame is None
        else ""
    )
    return f"nothing found in {len(empty)} frame{'s' * (len(empty) != 1)}, first {first.name}{ask}"


def _summary(out: str, total: int, new: int, count: dict[str, int]) -> str:
    before = f", {total - new} of them before" if new < total else ""
    told = {ERROR: "bad", UNFINISHED: "unfinished", NOTED: "with a guessed or doubtful camera (notes, camera_doubt)"}
    wrong = "".join(f", {count[key]} {what}" for key, what in told.items() if count[key])
    return f"{'' if out == '-' else f'{out}: '}{total} frame{'s' * (total != 1)}{before}{wrong}"


EVERY = 0.2
"""Seconds between two pictures of the bar."""


class Frames:
    """Of ``left`` frames of ``total``, on standard error; what stood there before is not counted in the speed.

    ``at_work``: the frames that somebody is at; the slowest is named once it takes long.
    """

    def __init__(self, total: int, left: int, at_work: Callable[[], Sequence[AtWork]] = tuple) -> None:
        self._total, self._left, self._done, self._bad = total, left, 0, 0
        self._at_work = at_work
        self._start = self._told = monotonic()
        self._progress = Progress()

    def step(self, *, bad: bool) -> None:
        """One frame more is done."""
        self._done += 1
        self._bad += bad
        now = monotonic()
        if not self._progress.terminal or now - self._told >= EVERY:
            self._told = now
            done, text = self._total - self._left + self._done, self.text(now)
            self._progress.at(f"{bar(done, self._total)} {text}" if self._progress.terminal else text)

    def tick(self) -> None:
        """Some time has gone by: name the frame that somebody has been at for longest, where that is long.

        Without a bar, which would leave no room for the rest.
        """
        at_work, now = self._at_work(), monotonic()
        slowest = min(at_work, key=lambda some: some.since, default=None)
        if slowest is not None and now - slowest.since >= SELDOM:
            number = f", {len(at_work)} at work" * (len(at_work) > 1)
            name = slowest.frame.name
            if self._progress.terminal and len(name) > WIDTH:
                name = f"...{name[3 - WIDTH :]}"
            stage = f": {slowest.stage}" * bool(slowest.stage)
            with suppress(RuntimeError):  # a line is being written
                self._progress.at(so_far(f"{self.text(now)}{number}; {name}{stage}", now - slowest.since))

    def say(self, line: str) -> None:
        """A line that stays, above the bar."""
        self._progress.above(say)(line)

    def end(self) -> None:
        """Take the bar away."""
        self._progress.end()

    def text(self, now: float) -> str:
        """``120 of 1000 frames, 1 bad, about 2 min left``; how long is known once one is done."""
        bad = f", {self._bad} bad" if self._bad else ""
        told = f"{self._total - self._left + self._done} of {self._total} frames{bad}"
        if not self._done:
            return told
        seconds = (now - self._start) / self._done * (self._left - self._done)
        return f"{told}, about {duration(seconds)} left"
