"""``plogic batch``: many frames, one line of JSON each, by several processes or a Dask cluster."""

import json
import os
from collections.abc import Iterable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path

import click

from geometry.files.camera_files import read_camera
from plogic.base.children import ending_well
from plogic.face.shown.options import Batching
from plogic.run.batch.frame_lines import ERROR, UNFINISHED
from plogic.run.batch.frames import Frame, Settings, checked, frames_of
from plogic.run.batch.frames_run import Engine, Waiting, run, waiting_beside
from plogic.run.batch.log import Log, check_out, check_same, left_over, log_at
from plogic.run.batch.pool import Pool
from plogic.run.batch.progress import Progress

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
    if settings.camera is not None:  # every picture would say what is wrong with it
        read_camera(checked(settings.camera))
    frames = frames_of(inputs, listed)
    with ending_well():
        engine = _engine(settings, options)
        try:
            engine.start(len(frames))
            kb = engine.kb()
            with log_at(out) as log, closing(Waiting(beside)) as waiting:
                return _run(frames, engine, log, waiting, settings, kb, out, in_order=options.order == "input")
        finally:
            engine.close()


def _engine(settings: Settings, options: Batching) -> Engine:
    if options.dask is not None:
        from plogic.run.batch.dask import Cluster

        said = partial(click.echo, err=True)
        return Cluster(settings, str(Path.cwd()), options.dask, options.timeout, said)
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
    before = {(line.input, line.frame) for line in (*log.written, *waiting.written)}
    progress = Progress(len(frames), len(frames) - len(before))

    def write(frame: Frame, status: str, line: bytes) -> None:
        log.write(line)
        if status in count:
            count[status] += 1
        if status == ERROR:
            progress.say(_why(frame, line))
        if (frame.input, frame.frame) not in before:
            progress.step(bad=status == ERROR)

    try:
        run(left, engine, write, waiting, in_order=in_order)
    except BaseException:
        progress.end()
        progress.say(f"stopped; --resume goes on with {out}" if out != "-" else "stopped")
        raise
    progress.end()
    progress.say(_summary(out, len(frames), len(frames) - len(before), count[ERROR], count[UNFINISHED]))
    return BAD if count[ERROR] else LATE if count[UNFINISHED] else 0


def _why(frame: Frame, line: bytes) -> str:
    """The error of a line, its first mistake and how many there are, after the frame's name unless it says that itself."""
    first, *others = str(json.loads(line)["error"]).splitlines() or [""]
    named = first if first.startswith(frame.input) else f"{frame.name}: {first}"
    return named + (f" (and {len(others)} more)" if others else "")


def _summary(out: str, total: int, new: int, bad: int, unfinished: int) -> str:
    before = f", {total - new} of them before" if new < total else ""
    wrong = (f", {bad} bad" if bad else "") + (f", {unfinished} unfinished" if unfinished else "")
    return f"{'' if out == '-' else f'{out}: '}{total} frame{'s' * (total != 1)}{before}{wrong}"
