"""One worker, frame by frame: what it cannot read is a line and never a wait."""

from __future__ import annotations

import hashlib
import json
import os

import pytest
from small_frames import CAMERA, gamma, picture

from plogic.base.errors import InputError
from plogic.run.batch import work
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.log import check_same, left_over, log_at
from plogic.run.batch.work import Worker
from plogic.run.cameras import GivenCamera


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
        assert (status, json.loads(line)["error"]) == (
            "error",
            f"{frame.input}: is no plain file, but a pipe or a device",
        )


def test_a_pipe_in_the_place_of_a_camera_is_a_bad_frame(worker, folder, monkeypatch):
    (folder / "camera.json").unlink()
    os.mkfifo(folder / "camera.json")
    os.mkfifo(folder / "given")
    for given, named in ((None, "camera.json"), ("given", "given")):
        monkeypatch.setattr(worker, "settings", Settings("towers", camera=GivenCamera(given)))
        status, line = worker(Frame("a.png", None, "image"))
        assert (status, json.loads(line)["error"]) == ("error", f"{named}: is no plain file, but a pipe or a device")


def test_the_hash_is_that_of_the_bytes_themselves(worker, folder):
    g, a, camera = ((folder / name).read_bytes() for name in ("g.json", "a.png", "camera.json"))
    assert json.loads(worker(Frame("g.json", None, "gamma"))[1])["sha256"] == hashlib.sha256(g).hexdigest()
    assert json.loads(worker(Frame("a.png", None, "image"))[1])["sha256"] == hashlib.sha256(a + camera).hexdigest()


@pytest.mark.parametrize("content", [json.dumps(gamma(2)), "torn"])
def test_what_changes_while_it_is_read_is_a_bad_frame(worker, folder, monkeypatch, content):
    shot = work.shot_for

    def slow(*args):
        (folder / "g.json").write_text(content)
        return shot(*args)

    monkeypatch.setattr(work, "shot_for", slow)
    status, line = worker(Frame("g.json", None, "gamma"))
    row = json.loads(line)
    assert (status, row["error"], row["sha256"]) == ("error", "changed while it was read", None)


def test_what_changes_later_is_told_by_the_hash_of_what_was_read(worker, folder, monkeypatch):
    frame, before, perceiver = Frame("g.json", None, "gamma"), (folder / "g.json").read_bytes(), worker.perceiver

    class Slow:
        kb = perceiver.kb

        def __call__(self, *args):
            (folder / "g.json").write_text(json.dumps(gamma(2)))
            return perceiver(*args)

    monkeypatch.setattr(worker, "perceiver", Slow())
    status, line = worker(frame)
    assert (status, json.loads(line)["sha256"]) == ("done", hashlib.sha256(before).hexdigest())
    (folder / "out.jsonl").write_bytes(line)
    with log_at("out.jsonl") as log:
        assert left_over([frame], log.written, in_order=True) == []
        with pytest.raises(InputError, match=r"out.jsonl:1: g.json or its camera has changed"):
            check_same([frame], log.written, worker.settings, worker.lines.kb)


def test_lines_of_an_earlier_hash_are_refused_as_such(worker, folder):
    frame = Frame("g.json", None, "gamma")
    old = hashlib.sha256(hashlib.sha256((folder / "g.json").read_bytes()).digest()).hexdigest()
    (folder / "out.jsonl").write_bytes(worker.lines.wrong(frame, "bad", old)[1])
    with log_at("out.jsonl") as log, pytest.raises(InputError, match="was written by an earlier plogic"):
        check_same([frame], log.written, worker.settings, worker.lines.kb)
