"""How far something long has come: told by the clock, as one bar on a terminal, else as a line now and then."""

from __future__ import annotations

import io
import signal
import sys
import time

import pytest

from plogic.face.shown import progress


class Terminal(io.StringIO):
    """Says that it is one."""

    def isatty(self):
        """Yes."""
        return True


def waited(stream, words):
    """Wait until the stream holds these words, for ten seconds at most."""
    end = time.monotonic() + 10.0
    while words not in stream.getvalue() and time.monotonic() < end:
        time.sleep(0.005)
    assert words in stream.getvalue()


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(progress, "TICK", 0.01)
    monkeypatch.setattr(progress, "SELDOM", 0.03)


@pytest.mark.usefixtures("quick")
def test_work_is_told_though_no_step_of_it_ends(monkeypatch):
    """One stage that lasts: lines come all the same."""
    monkeypatch.setattr(sys, "stderr", stream := io.StringIO())
    with progress.Work(100.0, lambda line: stream.write(f"{line}\n")) as work:
        work.at("cup: 0 of 80 views")
        waited(stream, "cup: 0 of 80 views; 0 % of all\ncup: 0 of 80 views; 0 % of all\n")
        work.step(25.0)
        work.at("cup: 20 of 80 views")
        waited(stream, "cup: 20 of 80 views; 25 % of all, longer than expected\n")
        work.say("cup is learned")
    told = stream.getvalue()
    assert told.endswith("cup is learned\n") or told.splitlines()[-1].startswith("cup: 20 of 80 views")
    assert not {"\r", "#"} & set(told)
    time.sleep(0.1)
    assert stream.getvalue() == told, "nothing is told when it is over"


@pytest.mark.usefixtures("quick")
def test_on_a_terminal_one_line_with_a_bar_is_written_over_and_taken_away(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setattr(sys, "stderr", stream := Terminal())
    with progress.Work(100.0, lambda line: stream.write(f"{line}\n")) as work:
        work.at("a type of a long name: features")
        work.step(50.0)
        waited(stream, "[###############...............] a type of a long name: fea\033[K")
        work.say("a line that stays")
    told = stream.getvalue()
    assert told.endswith("\r\033[K")
    assert "\r\033[Ka line that stays\n" in told
    drawn = [piece.removesuffix("\033[K") for piece in told.split("\r") if piece.startswith("[")]
    assert drawn
    assert max(map(len, drawn)) <= 59, "what wraps could not be written over"


def test_the_time_left_is_what_the_speed_makes_of_the_rest(monkeypatch):
    clock = iter([0.0, 0.0, 60.0, 1000.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    work = progress.Work(200.0, print)
    work.at("cup: features")
    work.skip(80.0)
    work.step(30.0)
    assert work.text(60.0) == "cup: features; 25 % of all, about 3 min left"
    assert work.text(110.0) == "cup: features; 25 % of all, about 2 min left"
    assert work.text(1000.0) == "cup: features; 25 % of all, longer than expected"
    work.step(90.0)
    work.at("words of all types")
    assert work.text(1000.0) == "words of all types; the last phase, whose time is not known"


def test_no_alarm_draws_between_the_end_of_the_line_and_a_line_that_stays(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream := Terminal())
    told = progress.Progress()
    told.at("search")

    def interrupted(line):
        told.at("an alarm that comes now")
        stream.write(f"{line}\n")

    told.above(interrupted)("a line that stays")
    told.at("search again")
    assert stream.getvalue() == "\rsearch\033[K\r\033[Ka line that stays\n\rsearch again\033[K"


def test_what_is_soon_done_tells_nothing_on_a_terminal_either(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream := Terminal())
    with progress.beating(lambda: "search"):
        pass
    assert stream.getvalue() == ""


@pytest.mark.usefixtures("quick")
def test_what_nothing_is_counted_of_is_told_by_the_alarm(monkeypatch):
    """A search is told without a terminal too; afterwards the alarm is off, and nobody's own is taken."""
    monkeypatch.setattr(sys, "stderr", stream := io.StringIO())
    with progress.beating(lambda: "search"):
        waited(stream, "search; 0 s so far\nsearch; 0 s so far\n")
    told = stream.getvalue()
    time.sleep(0.1)
    assert stream.getvalue() == told
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    try:
        with progress.beating(lambda: "search"):
            time.sleep(0.1)
        assert (stream.getvalue(), signal.getsignal(signal.SIGALRM)) == (told, signal.SIG_IGN)
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
