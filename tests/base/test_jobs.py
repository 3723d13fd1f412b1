"""Jobs that copies of the process share in: the same results in the same order, whatever becomes of the copies."""

from __future__ import annotations

import os
import signal
import time
from contextlib import closing
from multiprocessing import active_children, get_context

import numpy as np
import pytest
from fresh_jobs import dies, half, resolved

from plogic.base import jobs
from plogic.base.jobs import ChildDiedError, afresh, each, growing, processors

HERE = os.getpid()


@pytest.fixture(params=[1, 2, 5])
def some(request):
    """So many processes."""
    return int(request.param)


@pytest.fixture(autouse=True)
def _nobody_is_left():
    yield
    assert active_children() == []


def later(number):
    """The earlier, the longer it takes."""
    time.sleep(0.002 * (12 - number))
    return number * number


def here(_):
    """In which process; long enough that nobody can do all."""
    time.sleep(0.02)
    return os.getpid()


def test_results_come_in_the_order_of_the_jobs(some):
    assert list(each(later, range(12), some)) == [n * n for n in range(12)]


def test_of_no_jobs_there_is_nothing(some):
    assert list(each(str, [], some)) == []


def test_each_process_does_its_share(some):
    who = set(each(here, range(30), some))
    assert HERE in who
    assert len(who) == some


def test_more_jobs_than_a_pipe_holds_are_done_in_turns(monkeypatch, some):
    monkeypatch.setattr(jobs, "MOST", 5)
    assert list(each(later, range(12), some)) == [n * n for n in range(12)]


def test_a_job_that_raises_does_so_here_in_its_turn(some):
    def done(number):
        if number == 3:
            raise ValueError(number, os.getpid())
        return number

    found = []
    with pytest.raises(ValueError, match=f"3, {HERE}"):
        found.extend(each(done, range(2000), some))
    assert found == [0, 1, 2]


def killed_elsewhere(number):
    time.sleep(0.01)
    if os.getpid() != HERE and number > 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def not_sent(number):
    """Nothing that can be pickled."""
    return lambda: number


def out_elsewhere(number):
    time.sleep(0.01)
    if os.getpid() != HERE:
        raise SystemExit
    return number


def test_what_a_copy_does_not_do_is_done_here(some):
    assert list(each(killed_elsewhere, range(10), some)) == list(range(10))
    assert list(each(out_elsewhere, range(10), some)) == list(range(10))
    assert [result() for result in each(not_sent, range(10), some)] == list(range(10))


def test_who_stops_asking_waits_for_nobody(some):
    def done(number):
        time.sleep(60.0 if number >= some and os.getpid() != HERE else 0.02)
        return number

    began = time.monotonic()
    with closing(each(done, range(1000), some)) as results:
        assert next(results) == 0
    assert time.monotonic() - began < 10.0  # this process alone takes 20 s for all


def test_who_may_have_no_children_does_all_alone():
    ours, theirs = get_context("fork").Pipe(duplex=False)
    child = get_context("fork").Process(target=lambda: theirs.send(set(each(here, range(4), 3))), daemon=True)
    child.start()
    assert ours.recv() == {child.pid}
    child.join()


def test_large_results_do_not_stop_a_copy():
    """Each is more than a pipe holds."""
    arrays = list(each(lambda n: np.full(300_000, n), range(8), 2))
    assert len(arrays) == 8
    assert all((array == n).all() and len(array) == 300_000 for n, array in enumerate(arrays))


def test_so_many_processes_as_is_stated_or_as_there_are_processors(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert processors() == 3
    for nonsense in ("", "many", "0", "-2", "9" * 5000):
        monkeypatch.setenv("OMP_NUM_THREADS", nonsense)
        assert 1 <= processors() <= (os.cpu_count() or 1)


def test_fresh_processes_answer_in_the_order_of_the_jobs(some):
    answers = list(afresh(half, range(7), some))
    assert [answer for answer, _ in answers] == [number / 2 for number in range(7)]
    assert len({pid for _, pid in answers} - {HERE}) == some
    assert list(afresh(half, [], some)) == []


def test_a_result_may_ask_for_more_and_that_is_done_next(some):
    """Each number asks for the two that follow on its double, up to a bound; with one process, before all others."""
    came = []

    def then(job, result):
        came.append((job, result[0]))
        return [2 * job, 2 * job + 1] if job < 3 else []

    growing(half, [1, 9], some, then)
    assert sorted(came) == [(job, job / 2) for job in (1, 2, 3, 4, 5, 9)]
    if some == 1:
        assert [job for job, _ in came] == [1, 2, 4, 5, 3, 9]
    with pytest.raises(ValueError, match="7"):
        growing(half, [6], some, lambda job, _: [job + 1])
    growing(half, [], some, then)


def test_what_a_fresh_process_raises_is_raised_here_in_its_turn(some):
    answers = afresh(half, range(9), some)
    assert [next(answers)[0] for _ in range(7)] == [number / 2 for number in range(7)]
    with pytest.raises(ValueError, match="7"):
        next(answers)


def test_a_fresh_process_that_dies_is_told(some):
    with pytest.raises(ChildDiedError, match="signal 9"):
        list(afresh(dies, range(10), some))


def test_a_fresh_process_runs_in_this_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert list(afresh(resolved, ["kb"], 1)) == [tmp_path / "kb"]
