"""``plogic batch``: many frames, one line of JSON each, by several processes or a Dask cluster."""

from __future__ import annotations

import math
import os
import sys
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plogic.face.shown.options import BEST_BY, CAMERA, FIRST_READING, KB, RECONSIDER, SMOOTHING, Number

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.run.batch.frames import Frame, Settings
    from plogic.run.batch.frames_run import Engine
    from plogic.run.batch.log import Log
    from plogic.run.batch.frames_run import Waiting

BAD, LATE = 1, 3
"""Exit statuses: a frame could not be perceived; the deadline cut one short."""


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("inputs", metavar="INPUTS...", nargs=-1, required=True)
@KB
@click.option(
    "--jobs",
    type=click.IntRange(1, 256),
    help="Processes at work on this machine, one thread each (default: one a core).",
)
@click.option(
    "--dask",
    metavar="ADDRESS",
    help="Scheduler of a Dask cluster to work instead, as tcp://HOST:8786; needs plogic[dask].",
)
@click.option("-o", "--out", default="-", help="File to append lines to; `-` is stdout (default).")
@click.option(
    "--resume", is_flag=True, help="Go on with the lines that the file has: skip what is done, cut a torn last line."
)
@click.option(
    "--order",
    type=click.Choice(["input", "done"]),
    default="input",
    show_default=True,
    help="Lines in the order of the inputs, or as they are done.",
)
@click.option(
    "--full",
    is_flag=True,
    help="Whole interpretations, as `perceive` writes them, in place of objects, poses and worlds.",
)
@click.option(
    "-n", "worlds", type=click.IntRange(0, 100), default=10, show_default=True, help="Worlds that a line lists."
)
@click.option(
    "--timeout",
    type=Number(0.0, min_open=True),
    help="Seconds that a frame may take; what takes longer is a bad frame.",
)
@CAMERA
@FIRST_READING
@RECONSIDER
@SMOOTHING
@BEST_BY
def batch(inputs: tuple[str, ...], kb_folder: str, out: str, **options: Any) -> None:  # noqa: ANN401 - click's
    r"""Perceive many frames: one line of JSON each, the same whoever works.

    INPUTS are pictures, Γ files (.json), folders with such at any depth, patterns in quotes, and BOP datasets; `-` is a
    list of them on stdin, one a line. A picture's camera is --camera, or camera.json beside it.

    A line (frame/1) has input, frame, status (done, unfinished, error), the SHA-256 of what was read, the KB and the
    options; then the accepted hypotheses with poses and probabilities and the most probable worlds, or the error. A bad
    frame is such a line and no stop; the exit status is then 1, and else 3 where --deadline left one unfinished. After
    a kill or Ctrl-C, --resume goes on.
    """
    if options["jobs"] and options["dask"] is not None:
        raise click.UsageError("--jobs and --dask exclude each other")
    if options["dask"] == "":
        raise click.UsageError("--dask needs an address, as tcp://HOST:8786")
    if out == "-" and options["resume"]:
        raise click.UsageError("--resume needs a file: -o OUT")
    for option in ("timeout", "deadline"):
        if options[option] == math.inf:
            raise click.UsageError(f"--{option} must be finite: leave it out to wait without end")
    sys.exit(batch_command(inputs, kb_folder, out, options, listed=sys.stdin))


def batch_command(
    inputs: Sequence[str], kb_folder: str, out: str, options: dict[str, Any], *, listed: Iterable[str]
) -> int:
    """Find the frames, start who works, write the lines; returns the exit status. ``listed``: what ``-`` among the inputs stands for.

    Raises:
        PlogicError: What is wrong with inputs, KB or file before any work; nothing is written then.
    """
    from plogic.base.children import ending_well
    from plogic.run.batch.frames import Settings
    from plogic.run.batch.frames import frames_of
    from plogic.run.batch.log import check_out, log_at
    from plogic.run.batch.frames_run import Waiting, waiting_beside

    beside = waiting_beside(out)
    check_out([] if out == "-" else [Path(out), *([beside] if beside is not None else [])], resume=options["resume"])
    chosen = {
        key: options[key] for key in ("camera", "reading", "reconsider", "smoothing", "deadline", "worlds", "full")
    }
    settings = Settings(kb_folder, **chosen)
    _check_camera(settings.camera)
    frames = frames_of(inputs, listed)
    with ending_well():
        engine = _engine(settings, options)
        try:
            engine.start(len(frames))
            kb = engine.kb()
            with log_at(out) as log, closing(Waiting(beside)) as waiting:
                return _run(frames, engine, log, waiting, settings, kb, out, in_order=options["order"] == "input")
        finally:
            engine.close()


def _check_camera(camera: str | None) -> None:
    """Raise PlogicError where --camera is no camera: every picture would say so."""
    if camera is None:
        return
    from geometry.files.camera_files import read_camera
    from geometry.files.plain_files import fault_of
    from plogic.base.errors import InputError

    fault = fault_of(Path(camera))
    if fault is not None:
        raise InputError(f"{camera}: {fault}")
    read_camera(camera)


def _engine(settings: Settings, options: dict[str, Any]) -> Engine:
    if options["dask"] is not None:
        from plogic.run.batch.dask import Cluster

        said = partial(click.echo, err=True)
        return Cluster(settings, str(Path.cwd()), options["dask"], options["timeout"], said)
    from plogic.run.batch.pool import Pool

    return Pool(settings, str(Path.cwd()), options["jobs"] or len(os.sched_getaffinity(0)), options["timeout"])


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
    from plogic.run.batch.frame_lines import ERROR, UNFINISHED
    from plogic.run.batch.frames_run import run
    from plogic.run.batch.log import check_same, left_over
    from plogic.run.batch.progress import Progress

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
    import json

    first, *others = str(json.loads(line)["error"]).splitlines() or [""]
    named = first if first.startswith(frame.input) else f"{frame.name}: {first}"
    return named + (f" (and {len(others)} more)" if others else "")


def _summary(out: str, total: int, new: int, bad: int, unfinished: int) -> str:
    before = f", {total - new} of them before" if new < total else ""
    wrong = (f", {bad} bad" if bad else "") + (f", {unfinished} unfinished" if unfinished else "")
    return f"{'' if out == '-' else f'{out}: '}{total} frame{'s' * (total != 1)}{before}{wrong}"
