"""Independent jobs in as many threads as the process may use, with the same results in the same order as one after another."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

Job = TypeVar("Job")
Result = TypeVar("Result")


def threads() -> int:
    """How many: as ``OMP_NUM_THREADS`` says, which other packages heed as well, or else one for each processor that the process may use."""
    stated = os.environ.get("OMP_NUM_THREADS", "")
    if stated.isdecimal() and int(stated) > 0:
        return int(stated)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(done: Callable[[Job], Result], jobs: Sequence[Job]) -> Generator[Result]:
    """As ``map``. Of who stops asking, or of a job that raises, no further job is begun; those under way are waited for."""
    if threads() < 2 or len(jobs) < 2:
        yield from map(done, jobs)
        return
    with ThreadPoolExecutor(threads()) as pool:
        under_way = [pool.submit(done, job) for job in jobs]
        try:
            for job in under_way:
                yield job.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
