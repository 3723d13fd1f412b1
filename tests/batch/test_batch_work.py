"""One worker, frame by frame: what it cannot read is a line and never a wait."""

from __future__ import annotations

import json
import os

import pytest
from small_frames import CAMERA, gamma, picture

from plogic.batch.frames import Frame, Settings
from plogic.batch.work import Worker


@pytest.fixture(scope="module")
def worker():
    """Of the towers."""
    return Worker(Settings("towers"))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Where the tests are: a Γ, and a picture with its camera."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    (tmp_path / "g.json").write_text(json.dumps(gamma(1)))
    picture(tmp_path / "a.png")
    return tmp_path


def test_a_pipe_that_came_since_the_frames_were_listed_is_a_bad_frame(worker, folder):
    for frame in (Frame("g.json", None, "gamma"), Frame("a.png", None, "image")):
        (folder / frame.input).unlink()
        os.mkfifo(folder / frame.input)
        status, line = worker(frame)
        assert (status, json.loads(line)["error"]) == ("error", f"{frame.input}: is no plain file, but a pipe or a device")


def test_a_pipe_in_the_place_of_a_camera_is_a_bad_frame(worker, folder, monkeypatch):
    (folder / "camera.json").unlink()
    os.mkfifo(folder / "camera.json")
    os.mkfifo(folder / "given")
    for given, named in ((None, "camera.json"), ("given", "given")):
        monkeypatch.setattr(worker, "settings", Settings("towers", camera=given))
        status, line = worker(Frame("a.png", None, "image"))
        assert (status, json.loads(line)["error"]) == ("error", f"{named}: is no plain file, but a pipe or a device")
