"""Jobs that come one after the other, which copies of this process do: the results in the same order.

As ``plogic.base.jobs``, where the jobs are not there yet when the work begins. The copies are made at once, so that
they know what the process knows, and share none of the threads that it starts later.

* ``with InTurn(done, 2) as work: for job, result in work.of(jobs): ...``
"""

from __future__ import annotations

from multiprocessing import Pipe, current_process
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Self, TypeVar

from plogic.base.children import Copy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection

Job = TypeVar("Job")
Result = TypeVar("Result")


class _Worker(NamedTuple):
    """A copy, and where it is told jobs and tells results."""

    copy: Copy
    end: Connection

    def told(self, job: object) -> bool:
        """Give it a job; False where it is gone."""
        try:
            self.end.send(job)
        except OSError:
            return False
        return True

    def answer(self) -> list[Any] | None:
        """The result in a list; an empty one where it failed, None where it is gone."""
        try:
            found: list[Any] = self.end.recv()
        except (EOFError, OSError):
            return None
        return found


class _End(NamedTuple):
    """There are no more jobs; ``error``: why, if they did not just end."""

    error: Exception | None


class InTurn(Generic[Job, Result]):
    """``done`` in so many copies, or, for one, in this process. Jobs and results can be pickled."""

    def __init__(self, done: Callable[[Job], Result], processes: int) -> None:
        self._done, self._over = done, False
        self._workers: list[_Worker] = []
        if processes > 1 and not current_process().daemon:
            for _ in range(processes):
                ours, theirs = Pipe()
                self._workers.append(_Worker(Copy(_work, done, theirs), ours))
                theirs.close()
        self._free: SimpleQueue[_Worker | None] = SimpleQueue()
        self._given: SimpleQueue[tuple[Job, _Worker | None] | _End] = SimpleQueue()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """End the copies; a thread that waits for a job is left waiting."""
        self._over = True
        self._free.put(None)
        for worker in self._workers:
            worker.copy.end()

    def of(self, jobs: Iterator[Job]) -> Iterator[tuple[Job, Result]]:
        """Each job with its result, in order; a job is asked for when somebody is idle.

        A job that a copy fails at, or dies of, is done by this process: whatever it raises is raised here, in its turn,
        as is what the jobs end with.
        """
        if not self._workers:
            for job in jobs:
                yield job, self._done(job)
            return
        for worker in self._workers:
            self._free.put(worker)
        Thread(target=self._give, args=(jobs,), daemon=True).start()
        while not isinstance(given := self._given.get(), _End):
            job, one = given
            answer = None if one is None else one.answer()
            result = answer[0] if answer else self._done(job)
            self._free.put(None if answer is None else one)
            yield job, result
        if given.error is not None:
            raise given.error

    def _give(self, jobs: Iterator[Job]) -> None:
        """In a thread: hand out jobs as they come and somebody is idle; None is who asked."""
        error = None
        try:
            while True:
                worker = self._free.get()
                if self._over:
                    return
                job = next(jobs)
                self._given.put((job, worker if worker is not None and worker.told(job) else None))
        except StopIteration:
            pass
        except Exception as fault:  # noqa: BLE001 - raised where the results are used
            error = fault
        self._given.put(_End(error))


def _work(done: Callable[[Any], Any], end: Connection) -> None:
    """What a copy does; who made it is interrupted, and ends it."""
    import signal
    from contextlib import suppress

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, OSError):
        while True:
            job = end.recv()
            try:
                end.send([done(job)])
            except Exception:  # noqa: BLE001 - who made this copy does it again, and raises
                end.send([])
