"""A worker's process as seen from outside: frames go in, answers come out, and at last it is killed or dies."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, astuple
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from plogic.logic.served.engine import environment

if TYPE_CHECKING:
    from plogic.run.batch.frames import Frame, Settings

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"
)
"""What libraries read when they are loaded, so that a worker keeps one core busy and no more. Embree's threads only
build, they cast no ray."""
LARGEST_READ = 1 << 20
"""Bytes that are read at a time."""


class Job(NamedTuple):
    """A frame with its place among those of the run; ``again``: a worker has died of it once."""

    number: int
    frame: Frame
    again: bool = False


class Process:
    """One worker. ``job``: what it is at work on; ``kb``: name and digest of what it has read; ``since``: when it could begin (monotonic)."""

    def __init__(self, settings: Settings, folder: str) -> None:
        command = [sys.executable, "-P", "-W", "ignore", "-m", "plogic.run.batch.worker_child"]
        pipe = subprocess.PIPE
        options: dict[str, Any] = {"env": environment(tempfile.gettempdir()) | ONE_THREAD, "cwd": folder}
        self._child = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, **options)  # noqa: S603 - our own module
        self._pieces: list[bytes] = []
        self.job: Job | None = None
        self.kb: dict[str, str] | None = None
        self.since = monotonic()
        self._tell(asdict(settings))

    def fileno(self) -> int:
        """Readable when there is an answer, or when it has died."""
        assert self._child.stdout is not None  # noqa: S101 - a pipe
        return self._child.stdout.fileno()

    def send(self, job: Job) -> None:
        """A frame to do; where the process is dead already, that will be read."""
        self.job, self.since = job, monotonic()
        self._tell(astuple(job.frame))

    def read(self) -> list[bytes] | None:
        """The lines that have become whole, without their ends; None once it has died. Waits where ``fileno`` is not readable."""
        piece = os.read(self.fileno(), LARGEST_READ)
        if not piece:
            return None
        *whole, rest = piece.split(b"\n")
        if not whole:
            self._pieces.append(rest)
            return []
        whole[0] = b"".join([*self._pieces, whole[0]])
        self._pieces = [rest]
        return whole

    def answered(self) -> int:
        """It is idle again; the number of the job that it has done."""
        assert self.job is not None  # noqa: S101 - it says nothing else
        number, self.job = self.job.number, None
        return number

    def end(self) -> str:
        """Kill it unless it has died already, and say how it ended: ``signal 9``, ``exit status 1``."""
        self._child.kill()
        status = self._child.wait()
        for pipe in (self._child.stdin, self._child.stdout):
            with contextlib.suppress(OSError):  # what was never read
                if pipe is not None:
                    pipe.close()
        return f"signal {-status}" if status < 0 else f"exit status {status}"

    def _tell(self, document: object) -> None:
        stdin = self._child.stdin
        assert stdin is not None  # noqa: S101 - a pipe
        with contextlib.suppress(BrokenPipeError):
            stdin.write(json.dumps(document).encode() + b"\n")
            stdin.flush()
