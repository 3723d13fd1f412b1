"""Workers on this machine, each a process of its own: who dies or takes too long costs its frame and no other.

``Process`` is one of them as seen from outside: frames go in, answers come out, and at last it is killed or dies.
"""

import contextlib
import json
import select
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import asdict, astuple
from time import monotonic
from typing import NamedTuple

from plogic.base.children import Child, python
from plogic.base.errors import InputError
from plogic.run.batch.frame_lines import Lines
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


class AtWork(NamedTuple):
    """A frame that somebody has been at work on ``since`` a moment (monotonic).

    ``stage``: what that one is at, '' where nobody tells.
    """

    frame: Frame
    since: float
    stage: str = ""


AT = "at"
"""What a worker's line begins with that tells the stage which it is at, where others have a frame's status."""


class Process:
    """One worker.

    ``job``: what it is at work on; ``kb``: name and digest of what it has read; ``since``: when it could begin
    (monotonic); ``stage``: what it said last that it is at.
    """

    def __init__(self, settings: Settings, folder: str) -> None:
        self._child = Child(python("plogic.run.batch.worker_child"), folder=folder, variables=ONE_THREAD)
        self._pieces: list[bytes] = []
        self.job: Job | None = None
        self.kb: dict[str, str] | None = None
        self.since, self.stage = monotonic(), ""
        self._tell(asdict(settings))

    def fileno(self) -> int:
        """Readable when there is an answer, or when it has died."""
        return self._child.fileno()

    def send(self, job: Job) -> None:
        """A frame to do; where the process is dead already, that will be read."""
        self.job, self.since, self.stage = job, monotonic(), ""
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


STARTS = 3
"""Workers that may die in a row before any was ready."""

PATIENCE = 1.0
"""Seconds after which those who may be late are looked at again, and by which a turn may be late itself."""


class Answer(NamedTuple):
    """The line of a frame, by its place among those of the run."""

    number: int
    status: str
    line: bytes


class Pool:
    """``jobs`` workers with one thread each, started when there is something to do.

    ``timeout``: seconds that a frame may take.

    ``folder``: that names of files are relative to.
    """

    def __init__(self, settings: Settings, folder: str, jobs: int, timeout: float | None = None) -> None:
        self._settings, self._folder, self._jobs, self._timeout = settings, folder, jobs, timeout
        self._workers: list[Process] = []
        self._left: deque[Job] = deque()
        self._failed = 0
        self._lines: Lines | None = None

    def start(self, number: int) -> None:
        """Let as many workers as there is work for, but one at least, read the KB from now on."""
        while len(self._workers) < max(1, min(self._jobs, number)):
            self._workers.append(Process(self._settings, self._folder))

    def kb(self) -> dict[str, str]:
        """Name and digest of the KB, as soon as a worker has read it. Raises InputError where it cannot be read."""
        while self._lines is None:
            self.start(1)
            for _ in self._heard(None):  # there is no answer yet
                pass
        return {"name": self._lines.kb["name"], "digest": self._lines.kb["digest"]}

    def answers(self, take: Callable[[], Job | None]) -> Iterator[Answer]:
        """The line of every frame that ``take`` gives, as they come, until it gives none and nothing is at work.

        Raises:
            InputError: No worker can read the KB, or it has changed.
        """
        self.kb()
        turn = monotonic()
        while self._fill(take):
            patience = self._patience()
            yield from self._heard(patience)
            self._excuse(monotonic() - turn - (patience or 0.0))
            turn = monotonic()
            yield from self._late()

    def at_work(self) -> list[AtWork]:
        """The frames that workers are at; may be asked while ``answers`` waits."""
        return [AtWork(w.job.frame, w.since, w.stage) for w in list(self._workers) if w.job is not None]

    def close(self) -> None:
        """Kill all workers; there will be no others, whoever is still waiting for answers."""
        self._jobs = 0
        while self._workers:
            self._workers.pop().end()

    def _fill(self, take: Callable[[], Job | None]) -> bool:
        """Give every idle worker a frame, and start those that are not there yet; whether any has something to do.

        Each has one at a time: behind a slow one none must wait.
        """
        for slot in range(self._jobs):
            if slot < len(self._workers) and self._workers[slot].job is not None:
                continue
            job = self._left.popleft() if self._left else take()
            if job is None:
                break
            self.start(slot + 1)
            self._workers[slot].send(job)
        return any(worker.job is not None for worker in self._workers)

    def _patience(self) -> float | None:
        """Seconds until the next worker may be late, a few at most; None for ever."""
        begun = [worker.since for worker in self._workers if worker.job is not None and worker.kb is not None]
        return (
            None
            if self._timeout is None or not begun
            else min(max(0.0, min(begun) + self._timeout - monotonic()), PATIENCE)
        )

    def _excuse(self, seconds: float) -> None:
        """A turn that came so much later than asked, as where we were stopped or unread, is no worker's fault."""
        if self._timeout is not None and seconds > PATIENCE:
            for worker in self._workers:
                worker.since = min(worker.since + seconds, monotonic())

    def _heard(self, seconds: float | None) -> Iterator[Answer]:
        """What workers say that speak within so many seconds."""
        for worker in select.select(self._workers, [], [], seconds)[0]:
            lines = worker.read()
            if lines is None:
                yield from self._dead(worker)
            for line in lines or ():
                status, _, text = line.partition(b" ")
                if worker.kb is None:
                    self._ready(worker, line)
                elif status == AT.encode():
                    worker.stage = text.decode()
                else:
                    yield Answer(worker.answered(), status.decode(), text + b"\n")

    def _ready(self, worker: Process, line: bytes) -> None:
        """Take note of a worker's KB, which must be that of all."""
        said = json.loads(line)
        if "error" in said:
            raise InputError(said["error"])
        if self._lines is not None and said["kb"] != self._lines.kb:
            raise InputError(f"{self._settings.kb}: has changed since this run began")
        self._lines = Lines(self._settings, said["kb"])
        worker.kb, worker.since, self._failed = said["kb"], monotonic(), 0

    def _late(self) -> Iterator[Answer]:
        """End the workers that take longer over a frame than they may, and have said nothing that is still unread."""
        if self._timeout is None:
            return
        for worker in list(self._workers):
            job = worker.job
            late = job is not None and worker.kb is not None and monotonic() - worker.since >= self._timeout
            if late and job is not None and not select.select([worker], [], [], 0)[0]:
                self._gone(worker)
                yield self._given_up(job, f"took longer than {self._timeout:g} s")

    def _dead(self, worker: Process) -> Iterator[Answer]:
        """What a worker was at that died by itself is done once more, and is to blame when that happens again."""
        how, job = self._gone(worker), worker.job
        if worker.kb is None:
            self._failed += 1
            if self._failed >= STARTS:
                raise InputError(f"{self._settings.kb}: the process that reads it ends before it is ready ({how})")
            self._left.extend([] if job is None else [job])
        elif job is not None and job.again:
            yield self._given_up(job, f"the process that perceives it dies ({how})")
        elif job is not None:
            self._left.append(job._replace(again=True))

    def _gone(self, worker: Process) -> str:
        """Forget a worker; how it ended."""
        self._workers.remove(worker)
        how = worker.end()
        return f"{how}, as for lack of memory" if how == "signal 9" else how

    def _given_up(self, job: Job, message: str) -> Answer:
        assert self._lines is not None  # noqa: S101 - some worker was ready
        return Answer(job.number, *self._lines.given_up(job.frame, message))
