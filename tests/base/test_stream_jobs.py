"""Jobs of a stream: every result in its turn, whoever does it, and none waits for the job after it."""

from __future__ import annotations

import os
import signal
import time
from threading import Event

import pytest

from plogic.base.stream_jobs import InTurn


def slow_if_even(job):
    time.sleep(0.05 * (job % 2 == 0))
    return job, os.getpid()


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_results_come_in_the_order_of_the_jobs(processes):
    with InTurn(slow_if_even, processes) as work:
        done = list(work.of(iter(range(9))))
    assert [(job, result[0]) for job, result in done] == [(n, n) for n in range(9)]
    here = {result[1] == os.getpid() for _, result in done}
    assert here == {processes == 1}


def test_a_result_does_not_wait_for_the_next_job():
    had = Event()

    def jobs():
        yield 1
        assert had.wait(10)
        yield 2

    with InTurn(slow_if_even, 2) as work:
        seen = []
        for job, _ in work.of(jobs()):
            seen.append(job)
            had.set()
    assert seen == [1, 2]


MAKER = os.getpid()


def dies_in_a_copy(job):
    if job == 2 and os.getppid() == MAKER:
        os.kill(os.getpid(), signal.SIGKILL)
    return job * 10


def test_what_a_copy_dies_of_is_done_here_and_so_is_the_rest():
    with InTurn(dies_in_a_copy, 2) as work:
        assert [result for _, result in work.of(iter([1, 2, 3, 2, 5, 6]))] == [10, 20, 30, 20, 50, 60]


def wrong_at_three(job):
    if job == 3:
        raise ValueError("three")
    return job


def test_an_error_is_raised_in_its_turn():
    with InTurn(wrong_at_three, 2) as work:
        results = work.of(iter(range(6)))
        assert [next(results)[1] for _ in range(3)] == [0, 1, 2]
        with pytest.raises(ValueError, match="three"):
            next(results)


def test_what_the_jobs_end_with_is_raised_after_the_last_result():
    def jobs():
        yield 1
        yield 2
        raise OSError("no more")

    with InTurn(slow_if_even, 2) as work:
        results = work.of(jobs())
        assert [next(results)[0] for _ in range(2)] == [1, 2]
        with pytest.raises(OSError, match="no more"):
            next(results)


def test_copies_are_gone_at_the_end():
    with InTurn(slow_if_even, 2) as work:
        ((_, (_, pid)),) = work.of(iter([1]))
        os.kill(pid, 0)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
