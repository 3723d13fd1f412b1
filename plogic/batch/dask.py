"""Workers of a Dask cluster that somebody else runs: each of its threads keeps a worker's process of ours, as a pool of one.

The workers must have plogic installed and see the same files under the same names.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import asdict, astuple
from importlib import import_module
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from geometry.errors import PlogicError
from plogic.batch.frames import Frame, Settings
from plogic.batch.lines import Lines
from plogic.batch.pool import Answer, Pool
from plogic.batch.process import Job
from plogic.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

AHEAD = 2
"""Frames that are sent to a cluster for each of its threads."""
CONNECTING = 10
"""Seconds that a scheduler has to answer in."""

Told = dict[str, Any]


class Cluster:
    """A connection to the scheduler at ``address``; otherwise as ``Pool``."""

    def __init__(self, settings: Settings, folder: str, address: str, timeout: float | None = None) -> None:
        """Connect. Raises InputError where the package is absent, nobody answers, or there are no workers."""
        distributed = _distributed()
        self._settings, self._address, self._dask = settings, address, distributed
        self._task: dict[str, Any] = {"settings": asdict(settings), "folder": folder, "timeout": timeout, "run": uuid4().hex}
        try:
            self._client: Any = distributed.Client(address, timeout=CONNECTING, set_as_default=False)
            self._threads = sum(self._client.nthreads().values())
        except (OSError, ValueError, TypeError) as error:
            raise InputError(f"{address}: no Dask scheduler answers there: {' '.join(str(error).split())}") from None
        if not self._threads:
            self._client.close()
            raise InputError(f"{address}: the Dask scheduler has no workers")
        self._lines: Lines | None = None

    def start(self, number: int) -> None:
        """As of a pool; here whoever gets the first frame starts."""

    def kb(self) -> dict[str, str]:
        """Name and digest of the KB as a worker reads it. Raises InputError where it cannot be read."""
        if self._lines is None:
            self._lines = Lines(self._settings, self._result(self._client.submit(_perceived, self._task, None, pure=False))["kb"])
        return dict(self._lines.kb)

    def answers(self, take: Callable[[], Job | None]) -> Iterator[Answer]:
        """As of a pool. Raises InputError also where the cluster is lost, or its workers read different KBs."""
        self.kb()
        coming, jobs = self._dask.as_completed(loop=self._client.loop), dict[object, Job]()
        while True:
            while coming.count() < AHEAD * self._threads and (job := take()) is not None:
                future = self._client.submit(_perceived, self._task, astuple(job.frame), pure=False)
                jobs[future.key] = job
                coming.add(future)
            if not coming.count():
                return
            future = next(coming)
            yield self._answer(jobs.pop(future.key), future)

    def close(self) -> None:
        """End our processes on the workers, as far as they can be reached, and the connection."""
        with suppress(Exception):  # the cluster may be gone
            self._client.run(_forget, self._task["run"])
        self._client.close()

    def _answer(self, job: Job, future: Any) -> Answer:  # noqa: ANN401 - a future of Dask
        assert self._lines is not None  # noqa: S101 - the KB was asked for first
        try:
            told = self._result(future)
        except InputError as error:
            if not isinstance(error.__cause__, self._dask.KilledWorker):
                raise
            return Answer(job.number, *self._lines.given_up(job.frame, "the Dask worker that perceives it dies, again and again"))
        if told["kb"] != self._lines.kb:
            raise InputError(f"{self._settings.kb}: is not the same on all Dask workers, or has changed since this run began")
        return Answer(job.number, told["status"], told["line"])

    def _result(self, future: Any) -> Told:  # noqa: ANN401 - a future of Dask
        try:
            told: Told = future.result()
        except Exception as error:
            what = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(f"{self._address}: the Dask cluster failed: {what}") from error
        if "error" in told:
            raise InputError(told["error"])
        return told


def _distributed() -> Any:  # noqa: ANN401 - the module
    """Dask's package, which is to keep its tracebacks to itself: what happens is told in one line."""
    try:
        import_module("dask").config.set({"logging": {"distributed": "critical", "distributed.client": "critical"}})
        return import_module("distributed")
    except ImportError:
        raise InputError("--dask needs the package distributed: pip install 'plogic[dask]'") from None


class _Kept:
    """The pools of one process, one a thread, each of one run."""

    def __init__(self) -> None:
        self._pools: dict[int, tuple[str, Pool]] = {}
        self._lock = threading.Lock()

    def pool(self, task: Told) -> Pool:
        """This thread's; that of another run is closed first."""
        thread = threading.get_ident()
        with self._lock:
            run, pool = self._pools.get(thread, ("", None))
            if pool is None or run != task["run"]:
                if pool is not None:
                    pool.close()
                pool = Pool(Settings(**task["settings"]), task["folder"], 1, task["timeout"])
                self._pools[thread] = task["run"], pool
        return pool

    def forget(self, run: str) -> None:
        """Close those of a run."""
        with self._lock:
            for thread in [thread for thread, (named, _) in self._pools.items() if named == run]:
                self._pools.pop(thread)[1].close()


_KEPT = _Kept()
"""In a Dask worker nothing else outlives a task."""


def _forget(run: str) -> None:
    _KEPT.forget(run)


def _perceived(task: Told, row: list[Any] | None) -> Told:
    """In a thread of a worker: the KB, and the line of a frame where there is one."""
    try:
        pool = _KEPT.pool(task)
        kb = pool.kb()
        jobs = [] if row is None else [Job(0, Frame(*row))]
        answers = list(pool.answers(lambda: jobs.pop() if jobs else None))
    except (PlogicError, OSError) as error:
        return {"error": str(error)}
    return {"kb": kb} | ({"status": answers[0].status, "line": answers[0].line} if answers else {})
