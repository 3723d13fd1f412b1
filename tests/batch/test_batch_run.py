"""Laws of a run, whoever works: every line once, in order where that is wanted, and never many held back."""

from __future__ import annotations

import sys
from io import StringIO

from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.batch import progress, run
from plogic.batch.frames import Frame
from plogic.batch.pool import Answer
from plogic.batch.progress import Progress, duration


class Shuffled:
    """Takes up to ``width`` frames, or as many as it gets, and answers any of them."""

    def __init__(self, width, random):
        self.width, self.random, self.most = width, random, 0

    def answers(self, take):
        """As an engine's."""
        held = []
        while True:
            while len(held) < self.width and (job := take()) is not None:
                held.append(job)
            if not held:
                return
            self.most = max(self.most, len(held))
            job = held.pop(self.random.randrange(len(held)))
            yield Answer(job.number, "done", job.frame.input.encode())


@given(st.integers(0, 60), st.integers(1, 80), st.booleans(), st.integers(1, 9), st.randoms(use_true_random=False))
@settings(deadline=None)
def test_every_frame_is_written_once(count, width, in_order, ahead, random):
    frames = [Frame(str(i), None, "gamma") for i in range(count)]
    engine, out = Shuffled(width, random), []

    def write(frame, status, line):
        assert (frame.input.encode(), status) == (line, "done")
        out.append(int(frame.input))

    kept, run.AHEAD = run.AHEAD, ahead
    try:
        run.run(frames, engine, write, in_order=in_order)
    finally:
        run.AHEAD = kept
    assert sorted(out) == list(range(count))
    if in_order:
        assert out == list(range(count))
        assert engine.most <= ahead


class Terminal(StringIO):
    """Says that it is one."""

    def isatty(self):
        """Yes."""
        return True


def test_a_bar_is_drawn_on_a_terminal_alone(monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.0)
    for stream, wanted in ((Terminal(), True), (StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        told = Progress(4, 2)
        told.step(bad=True)
        told.say("one is bad")
        told.step(bad=False)
        told.end()
        assert ("3 of 4 frames, 1 bad, about " in stream.getvalue()) is wanted
        assert "one is bad\n" in stream.getvalue()
        assert ("#" in stream.getvalue()) is wanted


def test_without_a_terminal_a_line_comes_now_and_then(monkeypatch):
    monkeypatch.setattr(progress, "SELDOM", 0.0)
    monkeypatch.setattr(sys, "stderr", StringIO())
    Progress(10, 10).step(bad=False)
    assert sys.stderr.getvalue().startswith("1 of 10 frames, about ")
    assert "\r" not in sys.stderr.getvalue()


def test_the_estimate_is_what_the_speed_of_this_run_makes_of_the_rest(monkeypatch):
    clock = iter([0.0, 30.0, 60.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    monkeypatch.setattr(sys, "stderr", StringIO())
    told = Progress(1000, 100)
    told.step(bad=False)
    told.step(bad=False)
    assert told.text(60.0) == "902 of 1000 frames, about 49 min left"


def test_durations():
    assert [duration(s) for s in (0, 99, 100, 5900, 7200, 200_000)] == ["0 s", "99 s", "2 min", "98 min", "2 h 0 min", "2 d 7 h"]
