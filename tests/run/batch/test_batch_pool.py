"""Who is to blame for the time, by a clock of our own and workers that are pipes."""

from __future__ import annotations

import os
import select as real
from types import SimpleNamespace

import pytest

from plogic.run.batch import pool
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.pool import AtWork, Job, Pool

KB = b'{"kb": {"name": "towers", "digest": "d"}}'


class Clock:
    """Goes on where somebody waits in vain, and where it is put on."""

    def __init__(self):
        self.now, self.stopped, self.asked = 0.0, 0.0, []

    def __call__(self):
        """Now."""
        return self.now

    def select(self, readers, writers, wrong, seconds):
        """As select's; where nothing can be read the seconds go by, and those that we are stopped for."""
        found = real.select(readers, writers, wrong, 0)
        if not found[0] and seconds != 0:
            assert seconds is not None
            self.asked.append(seconds)
            self.now, self.stopped = self.now + seconds + self.stopped, 0.0
        return found


class Worker:
    """Says its KB at once, and the answer to each frame but those called ``hangs``."""

    clock = None

    def __init__(self, *_):
        self.out, self.into = os.pipe()
        self.job, self.kb, self.since = None, None, self.clock()
        os.write(self.into, KB + b"\n")

    def fileno(self):
        """Of the pipe."""
        return self.out

    def send(self, job):
        """Answered at once, or never."""
        self.job, self.since, self.stage = job, self.clock(), ""
        if job.frame.input != "hangs":
            os.write(self.into, b"at search\ndone {}\n")
        else:
            os.write(self.into, b"at search, 3 of 8 types\n")

    def read(self):
        """What it said."""
        return os.read(self.out, 1 << 16).splitlines()

    def answered(self):
        """As a Process's."""
        number, self.job = self.job.number, None
        return number

    def end(self):
        """It is gone."""
        os.close(self.out)
        os.close(self.into)
        return "signal 9"


@pytest.fixture
def clock(monkeypatch):
    """The pool's time and its workers."""
    made = Clock()
    monkeypatch.setattr(Worker, "clock", made)
    monkeypatch.setattr(pool, "monotonic", made)
    monkeypatch.setattr(pool, "select", SimpleNamespace(select=made.select))
    monkeypatch.setattr(pool, "Process", Worker)
    return made


def answers(names, jobs, timeout):
    """One after the other, of frames of these names."""
    left = [Job(i, Frame(name, None, "lost", name)) for i, name in enumerate(names)][::-1]
    yield from Pool(Settings("towers"), "/", jobs, timeout).answers(lambda: left.pop() if left else None)


@pytest.mark.parametrize("patience", [pool.PATIENCE, 1e9])
def test_what_is_answered_while_nobody_reads_our_lines_is_not_late(clock, monkeypatch, patience):
    monkeypatch.setattr(pool, "PATIENCE", patience)
    told = []
    for answer in answers("abcdefgh", 3, 5.0):
        told.append((answer.number, answer.status))
        clock.now += 100.0
    assert sorted(told) == [(i, "done") for i in range(8)]


def test_who_hangs_is_late_by_the_time_that_we_were_there(clock):
    found = []
    for answer in answers(["a", "hangs", "b"], 2, 5.0):
        found.append((answer.number, answer.status))
        assert clock.now == (5.0 if answer.status == "error" else 0.0)
    assert found[-1] == (1, "error")


def test_the_time_that_we_were_stopped_for_is_nobodys_fault(clock):
    clock.stopped = 60.0
    assert [answer.status for answer in answers(["hangs"], 1, 5.0)] == ["error"]
    assert clock.now == 65.0
    assert clock.asked == [1.0] * 5


def test_the_patience_is_bounded(clock):
    clock.stopped = 1e12
    assert [answer.status for answer in answers(["hangs"], 1, 2.5)] == ["error"]
    assert max(clock.asked) == pool.PATIENCE


def test_a_huge_timeout_is_no_error(clock):
    assert [answer.status for answer in answers("a", 1, 1e300)] == ["done"]
    assert clock.now == 0.0


def test_what_workers_are_at_is_known_and_is_no_answer(clock):
    made, left = Pool(Settings("towers"), "/", 2, 5.0), [Job(i, Frame(n, None, "lost")) for i, n in enumerate("ab")]
    hangs = Job(2, Frame("hangs", None, "lost"))
    left.append(hangs)
    answers = made.answers(lambda: left.pop() if left else None)
    seen = [(answer.number, made.at_work()) for answer in answers]
    assert [number for number, _ in seen] == [1, 0, 2]
    assert seen[0][1] == [AtWork(hangs.frame, 0.0, "search, 3 of 8 types")]
    assert seen[-1][1] == []
