"""Jobs in threads: the same results in the same order, and none begun that nobody waits for."""

from __future__ import annotations

import os
import threading
import time
from contextlib import closing

import numpy as np
import pytest
from synthetic import cycle_of, one_before_the_other, scene
from test_cycle_remembers import told

from plogic.threads import each, threads


@pytest.fixture(params=["1", "2", "5"])
def some(request, monkeypatch):
    """So many threads."""
    monkeypatch.setenv("OMP_NUM_THREADS", request.param)
    return int(request.param)


def test_results_come_in_the_order_of_the_jobs(some):
    first = threading.Event()

    def done(number):
        if some > 1 and number == 0:
            first.wait(5.0)  # until a later one is done
        first.set()
        return number * number

    assert list(each(done, range(20))) == [n * n for n in range(20)]


def test_of_no_jobs_there_is_nothing(some):
    assert list(each(str, [])) == []


def test_the_first_job_that_raises_ends_it(some):
    begun = []

    def done(number):
        begun.append(number)
        if number == 3:
            raise ValueError(number)
        time.sleep(0.002)
        return number

    found = []
    with pytest.raises(ValueError, match="3"):
        found.extend(each(done, range(2000)))
    assert set(range(4)) <= set(begun)
    assert len(begun) < 2000


def test_who_stops_asking_lets_no_more_begin(some):
    begun, go = [], threading.Event()

    def done(number):
        begun.append(number)
        if some > 1 and number:
            go.wait(5.0)
        return number

    with closing(each(done, range(100))) as results:
        assert next(results) == 0
        threading.Timer(0.05, go.set).start()
    assert len(begun) <= some + 1


def test_the_cycle_says_the_same_in_one_thread_as_in_many(monkeypatch):
    rng = np.random.default_rng(6103)
    gamma = scene(rng, one_before_the_other(rng)).gamma
    answers = []
    for number in ("1", "4"):
        monkeypatch.setenv("OMP_NUM_THREADS", number)
        answers.append(told(cycle_of(gamma)))
    assert answers[0] == answers[1]
    assert answers[0][0], "something was accepted"


def test_so_many_threads_as_is_stated_or_as_there_are_processors(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert threads() == 3
    for nonsense in ("", "many", "0", "-2"):
        monkeypatch.setenv("OMP_NUM_THREADS", nonsense)
        assert 1 <= threads() <= (os.cpu_count() or 1)
