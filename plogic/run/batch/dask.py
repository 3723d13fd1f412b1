"""Workers of a Dask cluster that somebody else runs.

They must have plogic installed and see the same files under the same names.

``Connection`` reaches the scheduler: who does not answer, or has no workers, is waited for so long and no longer.
"""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, astuple
from importlib import import_module
from queue import Empty, SimpleQueue
from time import monotonic, sleep
from typing import Any
from uuid import uuid4

from plogic.base.errors import InputError
from plogic.run.batch.dask_worker import Told
from plogic.run.batch.frame_lines import Lines
from plogic.run.batch.frames import Settings
from plogic.run.batch.pool import Answer, AtWork, Job

CONNECTING = 10.0
"""Seconds that a scheduler has to answer in, whatever it is asked."""
WAITING = 60.0
"""Seconds that a scheduler may be without workers."""
LOOK = 2.0
"""Seconds between two looks for workers."""
CLOSING = 5.0
"""Seconds that taking leave may take."""


def distributed() -> Any:  # noqa: ANN401 - the module
    """Dask's package, which is to keep its tracebacks to itself: what happens is told in one line.

    Raises InputError where it is absent.
    """
    try:
        import_module("dask").config.set({"logging": {"distributed": "critical", "distributed.client": "critical"}})
        return import_module("distributed")
    except ImportError:
        raise InputError("--dask needs the package distributed: pip install 'plogic[dask]'") from None


class Connection:
    """To the scheduler at ``address``; ``say`` gets the lines that a user is to see meanwhile."""

    def __init__(self, address: str, say: Callable[[str], None]) -> None:
        """Connect. Raises InputError where the package is absent, or nobody answers in time."""
        self.address, self._say, self._empty, self._looked = address, say, 0.0, 0.0
        self.dask = distributed()
        try:
            asyncio.run(asyncio.wait_for(_greet(self.dask, address), CONNECTING))
            self.client: Any = self.dask.Client(address, timeout=CONNECTING, set_as_default=False)
        except Exception as error:
            what = " ".join(str(error).split()) or f"nothing is said within {CONNECTING:g} s"
            what = (
                "what answers is something else" if isinstance(error, MemoryError) else what
            )  # its first bytes are no length
            raise InputError(f"{address}: no Dask scheduler answers there: {what}") from error

    def wait(self) -> int:
        """The threads of all workers, as soon as there are any. Raises InputError as ``threads``."""
        while not (found := self.threads()):
            sleep(LOOK)
        return found

    def due(self) -> bool:
        """Whether it is time to ask for ``threads`` again."""
        return monotonic() - self._looked > LOOK

    def threads(self) -> int:
        """The threads of all workers; where there are none that is said once.

        Raises InputError where that lasts, or the scheduler is lost.
        """
        try:
            found = sum(self.client.nthreads(callback_timeout=CONNECTING).values())
        except Exception as error:
            raise self.failed(error) from error
        self._looked = now = monotonic()
        if found:
            self._empty = 0.0
        elif not self._empty:
            self._empty = now
            self._say(f"{self.address}: the Dask scheduler has no workers: waiting for them, for {WAITING:g} s")
        elif now - self._empty > WAITING:
            raise InputError(f"{self.address}: the Dask scheduler has had no workers for {WAITING:g} s")
        return found

    def failed(self, error: BaseException) -> InputError:
        """What is said of an error of the cluster's."""
        what = " ".join(f"{type(error).__name__}: {error}".split())
        if self.client.status != "running" or isinstance(error, OSError):
            what = "its scheduler is gone, or does not answer"
        return InputError(f"{self.address}: the Dask cluster failed: {what}")

    def close(self, farewell: Callable[[], object]) -> None:
        """Do a last thing, and let the scheduler forget what it was asked for: within some seconds, or not at all."""

        def leave() -> None:
            with suppress(Exception):  # the cluster may be gone
                farewell()

        left = threading.Thread(target=leave, daemon=True)
        left.start()
        left.join(CLOSING)
        with suppress(Exception):
            self.client.close(timeout=CLOSING)


async def _greet(dask: Any, address: str) -> None:  # noqa: ANN401 - the module
    """Raise whatever goes wrong where no scheduler answers."""
    comm = await dask.core.connect(address, timeout=CONNECTING, **dask.Security().get_connection_args("client"))
    try:
        await comm.write({"op": "identity", "reply": True})
        kind = (await comm.read())["type"]
    finally:
        comm.abort()
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind.lower()}")


AHEAD = 2
"""Frames that are sent to a cluster for each of its threads."""


class Cluster:
    """The cluster of the scheduler at ``address``; otherwise as ``Pool``.

    ``say`` gets the lines that a user is to see meanwhile.
    """

    def __init__(
        self, settings: Settings, folder: str, address: str, timeout: float | None, say: Callable[[str], None]
    ) -> None:
        """Connect. Raises InputError where the package is absent, or nobody answers."""
        self._settings, self._address = settings, address
        self._task: dict[str, Any] = {
            "settings": asdict(settings),
            "folder": folder,
            "timeout": timeout,
            "run": uuid4().hex,
        }
        self._connection = Connection(address, say)
        self._done: SimpleQueue[str] = SimpleQueue()
        self._call = _call()
        self._lines: Lines | None = None
        self._jobs: dict[str, tuple[Job, Any, float]] = {}

    def start(self, number: int) -> None:
        """As of a pool; here whoever gets the first frame starts."""

    def kb(self) -> dict[str, str]:
        """Name and digest of the KB as a worker reads it.

        Raises InputError where it cannot be read, or there are no workers.
        """
        if self._lines is None:
            self._connection.wait()
            future = self._submit(None)
            self._next()
            self._lines = Lines(self._settings, self._result(future)["kb"])
        return {"name": self._lines.kb["name"], "digest": self._lines.kb["digest"]}

    def answers(self, take: Callable[[], Job | None]) -> Iterator[Answer]:
        """As of a pool. Raises InputError also where the cluster is lost, or its workers read different KBs."""
        self.kb()
        threads = self._connection.wait()
        while True:
            while len(self._jobs) < AHEAD * threads and (job := take()) is not None:
                future = self._submit(job)
                self._jobs[future.key] = job, future, monotonic()
            if not self._jobs:
                return
            job, future, _ = self._jobs.pop(self._next())
            yield self._answer(job, future)
            threads = self._connection.threads() or threads if self._connection.due() else threads

    def at_work(self) -> list[AtWork]:
        """The frames that the cluster has, since it has them; what it is at nobody tells."""
        return [AtWork(job.frame, since) for job, _, since in list(self._jobs.values())]

    def close(self) -> None:
        """End our processes on the workers, as far as they can be reached, and the connection."""
        self._connection.close(lambda: self._connection.client.run(self._call, "forget", self._task["run"]))

    def _submit(self, job: Job | None) -> Any:  # noqa: ANN401 - a future of Dask
        try:
            future = self._connection.client.submit(
                self._call, "perceived", self._task, None if job is None else astuple(job.frame), pure=False
            )
        except Exception as error:
            raise self._connection.failed(error) from error
        future.add_done_callback(lambda done: self._done.put(done.key))
        return future

    def _next(self) -> str:
        """The key of a future that is done. Raises InputError where nobody works at any."""
        while True:
            try:
                return self._done.get(timeout=LOOK)
            except Empty:
                self._connection.threads()

    def _answer(self, job: Job, future: Any) -> Answer:  # noqa: ANN401 - a future of Dask
        assert self._lines is not None  # noqa: S101 - the KB was asked for first
        try:
            told = self._result(future)
        except InputError as error:
            if not isinstance(error.__cause__, self._connection.dask.KilledWorker):
                raise
            return Answer(
                job.number, *self._lines.given_up(job.frame, "the Dask worker that perceives it dies, again and again")
            )
        if told["kb"] != self._lines.kb:
            raise InputError(
                f"{self._settings.kb}: is not the same on all Dask workers, or has changed since this run began"
            )
        return Answer(job.number, told["status"], told["line"])

    def _result(self, future: Any) -> Told:  # noqa: ANN401 - a future of Dask
        try:
            told: Told = future.result()
        except Exception as error:
            raise self._connection.failed(error) from error
        if "error" in told:
            raise InputError(told["error"])
        if "lacking" in told:
            raise InputError(
                f"{self._address}: a Dask worker lacks plogic, or has another one than is here: {told['lacking']}"
            )
        return told


def _call() -> Callable[..., Any]:
    """Call a function of ``plogic.run.batch.dask_worker`` by its name; local, so that it is sent whole.

    A module that a worker cannot import would end the worker.
    """

    def call(name: str, *args: object) -> Any:  # noqa: ANN401 - whatever it returns
        import importlib

        try:
            module = importlib.import_module("plogic.run.batch.dask_worker")
        except ImportError as error:
            return {"lacking": str(error)}
        return getattr(module, name)(*args)

    return call
