"""The process of a session: answers as of a fresh one, one start for many questions, nothing left behind."""

from __future__ import annotations

import gc
import os

import pytest

from plogic.base.errors import LimitError
from plogic.logic.served import engine
from plogic.logic.served.engine import Limits, Process, Text, request_of, run, run_until, through
from plogic.scene.asking.query import answers

PROGRAM = Text(
    "0.3::a. 0.4::b(1). 0.5::b(2). c(X) :- a, b(X). c(3) :- \\+ b(2).\n"
    "slow :- between(1, 300, X), between(1, 300, Y), between(1, 300, Z), X + Y + Z < 0.\n"
)


@pytest.fixture
def process():
    process = Process(Limits(seconds=4))
    yield process
    process.close()


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def pid_of(process):
    return process._running.pid


def test_the_answers_are_those_of_a_fresh_process_each_time(process):
    goals = ["c(X)", "b(X), \\+ a", "a"]
    with through(process.ask):
        kept = [answers(PROGRAM, goal, given=["c(3)"]) for goal in [*goals, *goals]]
    assert kept[:3] == kept[3:] == [answers(PROGRAM, goal, given=["c(3)"]) for goal in goals]
    assert process.started == 1


def test_outside_it_questions_go_elsewhere(process):
    with through(process.ask):
        pass
    assert [a.goal for a in answers(PROGRAM, "a")] == ["a"]
    assert process.started == 0


def test_too_slow_a_question_ends_it_and_the_next_starts_another(process):
    with through(process.ask):
        answers(PROGRAM, "a")
        first = pid_of(process)
        process.limits, limits = Limits(seconds=0.5), process.limits
        with pytest.raises(LimitError, match=r"longer than 0\.5 s"):
            answers(PROGRAM, "slow")
        process.limits = limits
        assert not alive(first)
        assert answers(PROGRAM, "a")[0].probability == pytest.approx(0.3)
    assert process.started == 2


def test_a_process_that_was_killed_is_started_again(process):
    with through(process.ask):
        answers(PROGRAM, "a")
        os.kill(pid_of(process), 9)
        process._running.wait()
        assert answers(PROGRAM, "a")[0].probability == pytest.approx(0.3)
    assert process.started == 2


def test_too_little_memory_is_told_and_the_next_question_is_answered():
    limits = Limits(seconds=60, megabytes=300)
    process = Process(limits)
    with through(process.ask):
        with pytest.raises(LimitError, match="300 MB"):
            answers(PROGRAM, "length(L, 100000000)", limits=limits)
        assert answers(PROGRAM, "a", limits=limits)[0].probability == pytest.approx(0.3)
    assert process.started == 2


def test_nothing_stays_when_the_session_is_forgotten():
    process = Process(Limits())
    process.ask(request_of([PROGRAM], ["a"], [], None))
    pid, scratch = pid_of(process), process._running.folder
    assert alive(pid)
    del process
    gc.collect()
    assert not alive(pid)
    assert not os.path.exists(scratch)  # noqa: PTH110 - a name that mkdtemp gave


CRASHING = """
import os, signal

class SddManager:
    from_vtree = from_cnf_string = lambda *_: os.kill(os.getpid(), signal.SIGSEGV)

def Vtree(*_):
    return None
"""


@pytest.fixture
def crashing(tmp_path, monkeypatch):
    """A PySDD that ends its process, for all processes that are started."""
    (tmp_path / "pysdd").mkdir()
    (tmp_path / "pysdd/__init__.py").touch()
    (tmp_path / "pysdd/sdd.py").write_text(CRASHING)
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.usefixtures("crashing")
def test_where_pysdd_crashes_the_program_is_counted_without(process, monkeypatch):
    text = Text("0.3::a. 0.4::b. c :- a, \\+ b. c :- b, d. d :- c. query(c).")
    assert [found.probability for found in run([text])[0]] == [pytest.approx(0.18)]
    ((found,),), exact = run_until([text], seconds=20)
    assert (found.probability, exact) == (pytest.approx(0.18), True)
    with through(process.ask):
        assert run([text])[0][0].probability == pytest.approx(0.18)
    assert process.started == 2
    monkeypatch.setattr(engine, "CRASHES", ())
    with pytest.raises(LimitError, match="ended without an answer: signal 11"):
        run([text])
