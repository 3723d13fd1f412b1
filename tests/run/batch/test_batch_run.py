"""Laws of a run, whoever works: every line once, in order where that is wanted, and never many held back."""

from __future__ import annotations

import json
import sys
import tempfile
from contextlib import closing
from io import StringIO
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.face.commands import batch as progress
from plogic.face.commands.batch import Frames, duration
from plogic.face.shown import progress as lines
from plogic.run.batch import frames_run as run
from plogic.run.batch.frame_lines import Lines as Made
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.frames_run import Waiting
from plogic.run.batch.pool import Answer, AtWork


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
            job = held.pop(self.random.randrange(len(held)) if self.random else 0)
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


class Lines:
    """Keeps what is written, as a log does."""

    def __init__(self):
        self.text = b""

    def write(self, _frame, _status, line):
        """As of a log."""
        self.text += line


def killed_and_gone_on_with(folder, order, kills):
    """The lines of a run over lost frames, killed so many answers after its start each time, and perceived frames."""
    frames = [Frame(f"{i}.png", None, "lost", "is ünfit") for i in range(len(order))]
    lines, place, perceived, out = (
        Made(Settings("towers"), {"name": "towers", "digest": "d"}),
        folder / "out.waiting",
        [],
        Lines(),
    )

    class Killed:
        def __init__(self, answers):
            self.left = answers

        def answers(self, take):
            jobs = []
            while (job := take()) is not None:
                jobs.append(job)
            for job in sorted(jobs, key=lambda job: order[int(job.frame.input.partition(".")[0])])[: self.left]:
                perceived.append(job.frame)
                yield Answer(job.number, *lines.given_up(job.frame, job.frame.at))

    for number in [*kills, len(order)]:
        left = [frame for frame in frames if json.dumps(frame.input).encode() not in out.text]
        with closing(Waiting(place)) as waiting:
            run.run(left, Killed(number), out.write, waiting, in_order=True)
    wanted = b"".join(lines.given_up(frame, frame.at)[1] for frame in frames)
    return out.text, wanted, perceived, place


@given(st.permutations(range(9)), st.lists(st.integers(0, 5), max_size=4), st.integers(1, 4))
@settings(deadline=None)
def test_what_waits_for_its_turn_survives_kills_and_is_done_once(order, kills, stale):
    kept, run.STALE = run.STALE, stale
    try:
        with tempfile.TemporaryDirectory() as folder:
            text, wanted, perceived, place = killed_and_gone_on_with(Path(folder), order, kills)
            assert text == wanted
            assert len(perceived) == len(set(perceived)) == len(order)
            assert not place.exists()
    finally:
        run.STALE = kept


def test_what_waited_is_written_first_out_of_order_and_a_torn_end_of_it_is_cut(tmp_path):
    place = tmp_path / "out.waiting"
    lines = Made(Settings("towers"), {"name": "towers", "digest": "d"})
    frames = [Frame(f"{i}.png", None, "lost", "is unfit") for i in range(3)]
    made = [lines.given_up(frame, frame.at)[1] for frame in frames]
    place.write_bytes(made[2] + made[1][:-4])
    out = Lines()
    with closing(Waiting(place)) as waiting:
        run.run(frames[1:], Shuffled(1, None), out.write, waiting, in_order=False)
    assert out.text == made[2] + b"1.png"
    assert not place.exists()


class Terminal(StringIO):
    """Says that it is one."""

    def isatty(self):
        """Yes."""
        return True


def test_a_bar_is_drawn_on_a_terminal_alone(monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.0)
    for stream, wanted in ((Terminal(), True), (StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        told = Frames(4, 2)
        told.step(bad=True)
        told.say("one is bad")
        told.step(bad=False)
        told.end()
        assert ("3 of 4 frames, 1 bad, about " in stream.getvalue()) is wanted
        assert "one is bad\n" in stream.getvalue()
        assert ("#" in stream.getvalue()) is wanted


def test_without_a_terminal_a_line_comes_now_and_then(monkeypatch):
    clock = iter([0.0, 9.9, 10.0, 10.0, 12.0, 20.0, 20.0])
    monkeypatch.setattr(lines, "monotonic", lambda: next(clock))
    monkeypatch.setattr(sys, "stderr", StringIO())
    told = Frames(10, 10)
    for _ in range(4):
        told.step(bad=False)
    assert sys.stderr.getvalue().count("\n") == 2, "one after ten seconds, one ten seconds after that"
    assert sys.stderr.getvalue().startswith("2 of 10 frames, about ")
    assert "\r" not in sys.stderr.getvalue()


def slow_ones(*since):
    """Frames that are at work since these moments."""
    return [
        AtWork(Frame("/photos/of/a/folder/whose/name/is/long/lmo", f"000002/00009{i}", "bop"), when, stage)
        for i, (when, stage) in enumerate(since)
    ]


def test_the_frame_that_takes_longest_is_named_without_a_terminal(monkeypatch):
    now = [0.0]
    for module in (progress, lines):
        monkeypatch.setattr(module, "monotonic", lambda: now[0])
    monkeypatch.setattr(sys, "stderr", StringIO())
    working = []
    told = Frames(3, 3, lambda: working)
    for second in range(1, 31):
        now[0] = float(second)
        working[:] = slow_ones((5.0, "search, 3 of 8 types"), (4.0, "search, 1 of 8 types"))
        told.tick()
    working.pop()
    told.step(bad=False)
    now[0] = 41.0
    told.tick()
    name = "/photos/of/a/folder/whose/name/is/long/lmo 000002/00009"
    assert sys.stderr.getvalue().splitlines() == [
        f"0 of 3 frames, 2 at work; {name}1: search, 1 of 8 types; 10 s so far",
        f"0 of 3 frames, 2 at work; {name}1: search, 1 of 8 types; 20 s so far",
        f"1 of 3 frames, about 82 s left; {name}0: search, 3 of 8 types; 36 s so far",
    ]


def test_what_is_soon_done_is_not_named(monkeypatch):
    now = [0.0]
    for module in (progress, lines):
        monkeypatch.setattr(module, "monotonic", lambda: now[0])
    monkeypatch.setattr(sys, "stderr", StringIO())
    told = Frames(300, 300, lambda: slow_ones((now[0] - 9.5, "search")))
    for second in range(100):
        now[0] = float(second)
        told.tick()
    assert sys.stderr.getvalue() == ""


def test_on_a_terminal_a_long_name_leaves_room_for_the_stage(monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(sys, "stderr", stream := Terminal())
    told = Frames(3, 3, lambda: slow_ones((0.0, "search, 3 of 8 types")))
    monkeypatch.setattr(progress, "monotonic", lambda: 12.0)
    told.tick()
    name = "...e/is/long/lmo 000002/000090"
    assert stream.getvalue() == f"\r0 of 3 frames; {name}: search, 3 of 8 types; 12 s so far\033[K"


def test_the_estimate_is_what_the_speed_of_this_run_makes_of_the_rest(monkeypatch):
    clock = iter([0.0, 30.0, 60.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    monkeypatch.setattr(sys, "stderr", StringIO())
    told = Frames(1000, 100)
    told.step(bad=False)
    told.step(bad=False)
    assert told.text(60.0) == "902 of 1000 frames, about 49 min left"


def test_durations():
    assert [duration(s) for s in (0, 99, 100, 5900, 7200, 200_000)] == [
        "0 s",
        "99 s",
        "2 min",
        "98 min",
        "2 h 0 min",
        "2 d 7 h",
    ]
