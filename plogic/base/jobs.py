"""Independent jobs that processes share in: the same results in the same order as one after another.

A copy (``fork``) knows all that the process knows, so nothing is sent to it; what it finds comes back pickled, through
a pipe that nobody else writes to. Threads would not do: most of a search is steps of Python between small arrays, and
the interpreter takes one at a time. A fresh process is told everything, and inherits no lock that a thread holds.

* ``each(done, jobs, 2)``: as ``map``, by this process and one copy
* ``afresh(done, jobs, 2)``: as ``map``, by two fresh processes
* ``growing(done, jobs, 2, then)``: so, as they come, with jobs that results make possible
"""

from __future__ import annotations

import os
import pickle
import sys
from collections import deque
from contextlib import ExitStack, closing, suppress
from itertools import count
from multiprocessing import Pipe, current_process
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, TypeVar

from geometry.digits import whole
from plogic.base.children import Child, Copy, begin, heard, python

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
    from multiprocessing.connection import Connection

Job = TypeVar("Job")
Result = TypeVar("Result")

MOST = 8192
"""Jobs at a time: their numbers, of ``_BYTES`` each, fit into a pipe."""
_BYTES = 4
_LENGTH = 8
"""Bytes that say how long a pickled answer is."""


class ChildDiedError(Exception):
    """A process of ``afresh`` ended before it answered; the message says how."""


def processors() -> int:
    """How many to use: ``OMP_NUM_THREADS``, which other packages heed as well, or as many as the process may use."""
    stated = os.environ.get("OMP_NUM_THREADS", "")
    return whole(stated, 2**16) or len(os.sched_getaffinity(0))


def each(done: Callable[[Job], Result], jobs: Sequence[Job], processes: int) -> Generator[Result]:
    """As ``map``, by at most so many ``processes``, this one among them.

    By this one alone where it may have no children.

    Whoever is idle takes the next job. One that raises does so here, in its turn: where a copy fails, or is killed,
    this process does its job.
    Of who stops asking no further job is begun. What jobs leave behind besides their results is lost with the copies. A
    process that has other threads should ask for one process only: a copy has none of them, and what they held stays
    held.
    """
    processes = min(processes, len(jobs))
    if processes < 2 or current_process().daemon:
        yield from map(done, jobs)
        return
    for start in range(0, len(jobs), MOST):
        yield from _shared(done, jobs[start : start + MOST], processes)


def _shared(done: Callable[[Job], Result], jobs: Sequence[Job], processes: int) -> Generator[Result]:
    left, put = os.pipe()
    os.write(put, b"".join(number.to_bytes(_BYTES, "little") for number in range(len(jobs))))
    os.close(put)  # who finds it empty finds its end
    copies = _Copies(done, jobs, left, processes - 1)
    try:
        results: dict[int, Result] = {}
        failed: set[int] = set()
        own = _taken(left)
        for wanted in range(len(jobs)):
            while wanted not in results:
                if copies.answer(results, wait=False):
                    continue
                number = None if wanted in failed else next(own, None)
                if number is not None:
                    failed.add(number)
                    with suppress(Exception):  # it is done again, and raises, in its turn
                        results[number] = done(jobs[number])
                        failed.remove(number)
                elif wanted in failed or not copies.answer(results, wait=True):
                    results[wanted] = done(jobs[wanted])
            yield results.pop(wanted)
    finally:
        copies.end()
        os.close(left)


def _taken(left: int) -> Iterator[int]:
    """The numbers of jobs that nobody else took."""
    while number := os.read(left, _BYTES):
        yield int.from_bytes(number, "little")


class _Copies:
    """Copies of this process at work, and a thread each that receives what one finds, so that none waits."""

    def __init__(self, done: Callable[[Job], Any], jobs: Sequence[Job], left: int, count: int) -> None:
        self._answers: SimpleQueue[tuple[int, Any] | None] = SimpleQueue()
        self._at_work, ends = [], []
        for _ in range(count):
            ours, theirs = Pipe(duplex=False)
            self._at_work.append(Copy(_work, done, jobs, left, theirs))
            theirs.close()
            ends.append(ours)
        self._open = count
        self._receivers = [Thread(target=self._receive, args=(end,), daemon=True) for end in ends]
        for receiver in self._receivers:
            receiver.start()

    def _receive(self, end: Connection) -> None:
        with end, suppress(Exception):
            while True:
                self._answers.put(end.recv())
        self._answers.put(None)

    def answer(self, results: dict[int, Any], *, wait: bool) -> bool:
        """Take one more result; False where there will be none, or, if nobody is to ``wait``, none is there yet."""
        while self._open if wait else not self._answers.empty():
            answer = self._answers.get()
            if answer is not None:
                results[answer[0]] = answer[1]
                return True
            self._open -= 1
        return False

    def end(self) -> None:
        """Kill those that are still at work."""
        for copy in self._at_work:
            copy.end()
        for receiver in self._receivers:
            receiver.join()


def _work(done: Callable[[Job], Any], jobs: Sequence[Job], left: int, end: Connection) -> None:
    """What a copy does: where it cannot go on it leaves the rest to who made it, and says nothing."""
    with suppress(BaseException):
        for number in _taken(left):
            end.send((number, done(jobs[number])))


def afresh(done: Callable[[Job], Result], jobs: Sequence[Job], processes: int) -> Generator[Result]:
    """As ``map``, by so many fresh processes.

    ``done`` is a function of a module, and it, jobs and results can be pickled. It runs in this process's folder.

    Of who stops asking no further job is begun.

    Raises:
        ChildDiedError: A process was killed. Whatever ``done`` raises, in its turn.
    """
    results = dict[int, tuple[bool, Any]]()
    with closing(_answers(done, deque(enumerate(jobs)), processes)) as answers:
        for wanted in range(len(jobs)):
            while wanted not in results:
                number, answer = next(answers)
                results[number] = answer
            good, result = results.pop(wanted)
            if not good:
                raise result
            yield result


def growing(
    done: Callable[[Job], Result],
    jobs: Iterable[Job],
    processes: int,
    then: Callable[[Job, Result], Iterable[Job]],
) -> None:
    """Do jobs by so many fresh processes, as ``afresh`` does, and those that ``then`` gives for each result first.

    ``then`` is called here, as results come; who is idle is at work meanwhile.

    Raises:
        ChildDiedError: A process was killed. Whatever ``done`` raises.
    """
    numbers = count()
    begun = dict(zip(numbers, jobs, strict=False))
    left = deque(begun.items())
    with closing(_answers(done, left, processes)) as answers:
        for number, (good, result) in answers:
            if not good:
                raise result
            more = dict(zip(numbers, list(then(begun.pop(number), result)), strict=False))
            begun |= more
            left.extendleft(reversed(more.items()))


def _answers(
    done: Callable[[Job], Any], left: deque[tuple[int, Job]], processes: int
) -> Generator[tuple[int, tuple[bool, Any]]]:
    """Number, and whether it succeeded with what it gave or raised, of each job that is ``left``, as they come.

    More may be put there meanwhile.
    """
    with ExitStack() as stack:
        workers = [
            _Fresh(stack.enter_context(Child(python("plogic.base.jobs"), folder=".")), done)
            for _ in range(min(processes, len(left)))
        ]
        while True:
            for worker in workers:
                if worker.job is None and left:
                    worker.take(left.popleft())
            busy = [worker for worker in workers if worker.job is not None]
            if not busy:
                return
            speaking = heard([worker.child for worker in busy], None)
            for worker in busy:
                if worker.child in speaking and (answer := worker.answer()) is not None:
                    worker.take(None)
                    yield answer


class _Fresh:
    """A process of ``afresh`` with the number of the job that it is at, None where it is idle."""

    def __init__(self, child: Child, done: Callable[[Any], Any]) -> None:
        self.child = child
        self.job: int | None = None
        self._said = bytearray()  # answers of megabytes come in many small pieces
        self._tell(done)

    def take(self, job: tuple[int, Any] | None) -> None:
        """Begin a job, if there is one."""
        self.job = None if job is None else job[0]
        if job is not None:
            self._tell(job[1])

    def answer(self) -> tuple[int, tuple[bool, Any]] | None:
        """Read some.

        Return the job's number, and whether it succeeded with what it gave or raised, once that is whole.
        """
        piece = self.child.read()
        if not piece:
            raise ChildDiedError(self.child.end())
        self._said += piece
        size = int.from_bytes(self._said[:_LENGTH], "little")
        if len(self._said) < _LENGTH + size or self.job is None:
            return None
        answer, self._said = memoryview(self._said)[_LENGTH:], bytearray()
        return self.job, pickle.loads(answer)  # noqa: S301 - from a process of ours

    def _tell(self, some: object) -> None:
        with suppress(BrokenPipeError):  # that it died will be read
            self.child.tell(pickle.dumps(some))


def _serve() -> None:
    """In a fresh process: read the function, then a job at a time, and answer each."""
    begin()
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)  # whatever a library prints is no answer
        done = pickle.load(sys.stdin.buffer)  # noqa: S301 - from the process that started this one
        with suppress(EOFError):
            while True:
                job = pickle.load(sys.stdin.buffer)  # noqa: S301 - likewise
                try:
                    answer = pickle.dumps((True, done(job)))
                except Exception as error:  # noqa: BLE001 - raised where it was asked
                    answer = pickle.dumps((False, error))
                out.write(len(answer).to_bytes(_LENGTH, "little") + answer)
                out.flush()


if __name__ == "__main__":
    _serve()
