"""What runs on a worker of a Dask cluster.

Each of its threads keeps a process of ours, as a pool of one, and nobody's work is gone on with.

A run's processes end when it ends, when it was killed (then its tasks are cancelled), and when they had nothing to do
for a while.
"""

import threading
from dataclasses import dataclass
from importlib import import_module
from time import monotonic, sleep
from typing import Any

from geometry.errors import PlogicError
from plogic.base.errors import InputError
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.pool import Job, Pool

IDLE = 60.0
"""Seconds for which a process is kept that has nothing to do."""
LOOK = 1.0
"""Seconds between two looks for what nobody wants any more."""

Told = dict[str, Any]


@dataclass
class _Entry:
    """A pool of one run; ``task``: what it is at, None where it is idle ``since`` (monotonic)."""

    run: str
    pool: Pool
    task: object = None
    since: float = 0.0


class _Kept:
    """The pools of one process, one a thread, each of one run."""

    def __init__(self) -> None:
        self._entries: dict[int, _Entry] = {}
        self._over = set[str]()
        self._lock = threading.Lock()
        self._watched = False

    def begin(self, task: Told, worker: Any) -> Pool:  # noqa: ANN401 - a worker of Dask
        """This thread's, which is at work from now on; that of another run is closed first.

        Raises InputError where the run is over.
        """
        thread, key = threading.get_ident(), worker.get_current_task()
        with self._lock:
            if task["run"] in self._over:
                raise InputError("the run is over")
            entry = self._entries.get(thread)
            if entry is None or entry.run != task["run"]:
                if entry is not None:
                    entry.pool.close()
                entry = _Entry(task["run"], Pool(Settings.of(task["settings"]), task["folder"], 1, task["timeout"]))
                self._entries[thread] = entry
            entry.task = key
            if not self._watched:
                self._watched = True
                threading.Thread(target=self._watch, args=(worker,), daemon=True).start()
        return entry.pool

    def end(self) -> None:
        """This thread's is idle."""
        with self._lock:
            entry = self._entries.get(threading.get_ident())
            if entry is not None:
                entry.task, entry.since = None, monotonic()

    def forget(self, run: str) -> None:
        """Close those of a run, which is over."""
        self._over.add(run)
        self._close(lambda entry: entry.run == run)

    def _watch(self, worker: Any) -> None:  # noqa: ANN401 - a worker of Dask
        while True:
            sleep(LOOK)
            self._close(
                lambda entry: (
                    monotonic() - entry.since > IDLE if entry.task is None else not _wanted(worker, entry.task)
                )
            )

    def _close(self, which: Any) -> None:  # noqa: ANN401 - a condition of entries
        with self._lock:
            for thread in [thread for thread, entry in self._entries.items() if which(entry)]:
                self._entries.pop(thread).pool.close()


def _wanted(worker: Any, key: object) -> bool:  # noqa: ANN401 - a worker of Dask
    """Whether the scheduler still asks for a task, as far as the worker knows."""
    task = worker.state.tasks.get(key)
    return task is not None and task.state != "cancelled"


_KEPT = _Kept()
"""In a Dask worker nothing else outlives a task."""
forget = _KEPT.forget


def perceived(task: Told, row: list[Any] | None) -> Told:
    """In a thread of a worker: the KB, and status and line of a frame where there is one; or what is wrong."""
    try:
        pool = _KEPT.begin(task, import_module("distributed").get_worker())
        kb = pool.kb()
        jobs = [] if row is None else [Job(0, Frame(*row))]
        answers = list(pool.answers(lambda: jobs.pop() if jobs else None))
    except (PlogicError, OSError) as error:
        return {"error": str(error)}
    finally:
        _KEPT.end()
    return {"kb": kb} | ({"status": answers[0].status, "line": answers[0].line} if answers else {})
