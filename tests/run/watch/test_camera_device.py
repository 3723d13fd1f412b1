"""A camera: its newest frame, what was skipped, and its end. A made one stands in, as no machine of ours has one."""

from __future__ import annotations

import json
from threading import Event

import numpy as np
import pytest
from in_process import told
from small_frames import CAMERA, KB

from plogic.base.errors import InputError
from plogic.run.watch import moments
from plogic.run.watch.moments import device_number, moments_of
from plogic.run.watch.newest import Newest

BLANK = np.full((48, 64, 3), 90, np.uint8)


class Camera:
    """Gives ``number`` frames, whose first pixel is their number, then none; ``pace`` is asked before each."""

    def __init__(self, number: int, pace=lambda _: None, unread=()) -> None:
        self._left, self._pace, self._unread, self.taken, self.released = number, pace, unread, -1, False

    def grab(self) -> bool:
        """Take the next one."""
        self._pace(self.taken + 1)
        self._left -= 1
        self.taken += 1
        return self._left >= 0

    def retrieve(self):
        """The one that was taken."""
        pixels = BLANK.copy()
        pixels[0, 0] = self.taken
        return (self.taken not in self._unread), pixels

    def release(self) -> None:
        """It is free."""
        self.released = True


@pytest.fixture
def plugged(monkeypatch):
    """Plug a made camera in: ``plugged(camera)`` returns what was asked of it."""

    def plug(camera):
        asked = []
        monkeypatch.setattr(moments, "opened", lambda *how: asked.append(how) or camera)
        return asked

    return plug


def test_of_frames_that_come_too_fast_the_newest_is_taken_and_the_skipped_are_counted(plugged):
    some, all_come = Event(), Event()

    def pace(number):
        if number == 1:
            some.wait(10)
        if number == 6:
            all_come.set()
            Event().wait(0.01)

    camera = Camera(6, pace)
    plugged(camera)
    seen = []
    with moments_of("0") as shown:
        seen.append(next(shown))
        some.set()
        all_come.wait(10)
        seen.append(next(shown))
        with pytest.raises(InputError, match=r"camera 0: gives no more frames \(it gave 6\)"):
            next(shown)
    assert [(m.number, m.skipped, int(m.pixels[0, 0, 0])) for m in seen] == [(0, 0, 0), (5, 4, 5)]
    assert seen[0].seconds == 0.0
    assert seen[1].seconds >= 0.0
    assert camera.released


def test_the_command_writes_lines_and_says_when_the_camera_is_gone(plugged, tmp_path):
    (tmp_path / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    waits = Event()
    asked = plugged(Camera(2, lambda number: number and waits.wait(0.5)))
    lines = told("watch", "0", "--kb", KB, "--camera", tmp_path / "camera.json")
    rows = [json.loads(line) for line in lines if line.startswith("{")]
    assert [(row["moment"]["input"], row["moment"]["number"]) for row in rows] == [("0", 0), ("0", 1)]
    assert lines[-1] == "plogic: camera 0: gives no more frames (it gave 2)"
    assert asked == [(0, (64, 48))]


def test_a_frame_that_cannot_be_read_is_a_line(plugged, tmp_path):
    (tmp_path / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    plugged(Camera(3, lambda number: number and Event().wait(0.5), unread={1}))
    lines = told("watch", "/dev/video3", "--limit", 2, "--kb", KB, "--camera", tmp_path / "camera.json")
    rows = [json.loads(line) for line in lines if line.startswith("{")]
    assert [row.get("error") for row in rows] == [None, "camera 3: frame 1 cannot be read"]


def test_every_third_frame_of_a_camera(plugged):
    plugged(Camera(7, lambda _: Event().wait(0.05)))
    with moments_of("2", every=3) as shown:
        assert [next(shown).number for _ in range(3)] == [0, 3, 6]


def test_what_is_a_camera(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert [device_number(name) for name in ("0", "12", "/dev/video4", "-", "clip.mp4")] == [0, 12, 4, None, None]
    (tmp_path / "0").write_bytes(b"")
    assert device_number("0") is None


def test_who_asks_in_time_gets_everything():
    asked = Event()

    def things():
        for thing in range(3):
            yield thing
            asked.wait(10)
            asked.clear()

    with Newest(things(), lambda thing, skipped: (thing, skipped)) as newest:
        got = []
        for one in newest:
            got.append(one)
            asked.set()
    assert got == [(0, 0), (1, 0), (2, 0)]
