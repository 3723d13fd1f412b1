"""Whole processes as people start them: ``problog FILE`` and ``plogic query FILE``, their processor seconds."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks.worlds.stock import SHORT

COMMANDS = {"sdd": ("-m", "problog"), "plogic": ("-m", "cli", "query")}
"""Stock's default, which is sdd where PySDD is installed, and ours."""
REPEATS = 3


@dataclass(frozen=True)
class Whole:
    """``seconds`` of the processor, with what it started; ``over``: it was ended at the limit of wall time."""

    seconds: float
    over: bool = False


def whole(text: str, command: str, limit: float) -> Whole:
    """The fastest of three runs of a command, of one where that is long."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "program.pl")
        file.write_text(text, encoding="utf-8")
        runs = [_once([sys.executable, *COMMANDS[command], str(file)], limit)]
        while len(runs) < REPEATS and not runs[-1].over and runs[-1].seconds < SHORT:
            runs.append(_once([sys.executable, *COMMANDS[command], str(file)], limit))
    return min(runs, key=lambda run: run.seconds)


def _once(command: list[str], limit: float) -> Whole:
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join([root, *(entry for entry in sys.path if entry)])
    quiet = subprocess.DEVNULL
    environment = {**os.environ, "PYTHONPATH": path}
    before = _children()
    with subprocess.Popen(command, stdout=quiet, stderr=quiet, env=environment, start_new_session=True) as child:  # noqa: S603 - our own modules and ProbLog's, no shell
        try:
            child.wait(limit)
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
            return Whole(limit, over=True)
    return Whole(_children() - before)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
