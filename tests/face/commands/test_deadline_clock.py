"""When the clock of ``--deadline`` starts.

``perceive`` and ``batch`` agree that knowledge base, index and detection are outside it.
"""

from __future__ import annotations

import json
import time

import cv2
import numpy as np
import pytest

import plogic.run.perceive
from plogic.face.commands.perceive import perceive_command
from plogic.face.shown.options import Perceiving
from plogic.run import sources
from plogic.run.batch import work
from plogic.run.batch.frames import Frame, Settings
from plogic.run.cameras import GivenCamera
from sensing.appearance import Gamma

SLOW, DEADLINE = 0.4, 5.0
CAMERA = {"width": 64, "height": 48, "K": [[60, 0, 32], [0, 60, 24], [0, 0, 1]], "dist": []}


@pytest.fixture
def left(monkeypatch):
    """Where the seconds that were left as perceiving began are told.

    Reading the KB, its index and detection are slow.
    """
    seconds = []

    class Slow(plogic.run.perceive.Perceiver):
        def __init__(self, *args):
            time.sleep(SLOW)
            super().__init__(*args)

        def __call__(self, gamma, options, *rest):
            seconds.append(options.end - time.monotonic())
            return super().__call__(gamma, options, *rest)

    def detected(_picture, camera, _kb, _clock):
        time.sleep(SLOW)
        return Gamma(camera, ())

    monkeypatch.setattr(plogic.run.perceive, "Perceiver", Slow)
    monkeypatch.setattr(sources, "detected", detected)
    return seconds


@pytest.fixture
def picture(tmp_path):
    (tmp_path / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    cv2.imwrite(str(tmp_path / "image.png"), np.full((48, 64, 3), 90, np.uint8))
    return tmp_path / "image.png"


def test_of_perceive(left, picture):
    options = Perceiving("towers", deadline=DEADLINE, camera=GivenCamera(str(picture.parent / "camera.json")))
    assert perceive_command([str(picture)], options, say=lambda _: None, write=lambda _: None) == 0
    assert left == [pytest.approx(DEADLINE, abs=SLOW / 2)]


def test_of_batch(left, picture):
    worker = work.Worker(Settings("towers", deadline=DEADLINE))
    assert worker(Frame(str(picture), None, "image"))[0] == "done"
    assert left == [pytest.approx(DEADLINE, abs=SLOW / 2)]
