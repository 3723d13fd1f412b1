"""A worker's process as seen from outside: frames go in, answers come out, and at last it is killed or dies."""

from __future__ import annotations

import contextlib
import json
from dataclasses import asdict, astuple
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from plogic.base.children import Child, python

if TYPE_CHECKING:
    from plogic.run.batch.frames import Frame, Settings

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"
)
"""What libraries read when they are loaded, so that a worker keeps one core busy and no more. Embree's threads only
build, they cast no ray."""


class Job(NamedTuple):
    """A frame with its place among those of the run; ``again``: a worker has died of it once."""

    number: int
    frame: Frame
    again: bool = False


class Process:
    """One worker.

    ``job``: what it is at work on; ``kb``: name and digest of what it has read; ``since``: when it could begin
    (monotonic).
    """

    def __init__(self, settings: Settings, folder: str) -> None:
        self._child = Child(python("plogic.run.batch.worker_child"), folder=folder, variables=ONE_THREAD)
        self._pieces: list[bytes] = []
        self.job: Job | None = None
        self.kb: dict[str, str] | None = None
        self.since = monotonic()
        self._tell(asdict(settings))

    def fileno(self) -> int:
        """Readable when there is an answer, or when it has died."""
        return self._child.fileno()

    def send(self, job: Job) -> None:
        """A frame to do; where the process is dead already, that will be read."""
        self.job, self.since = job, monotonic()
        self._tell(astuple(job.frame))

    def read(self) -> list[bytes] | None:
        """The lines that have become whole, without their ends; None once it has died.

        Waits where ``fileno`` is not readable.
        """
        piece = self._child.read()
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
        return self._child.end()

    def _tell(self, document: object) -> None:
        with contextlib.suppress(BrokenPipeError):
            self._child.tell(json.dumps(document).encode() + b"\n")
