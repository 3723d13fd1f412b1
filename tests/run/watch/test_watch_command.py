"""``plogic watch`` as a user runs it: of a video, of pictures on stdin, and ended by whoever reads it or by Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import cv2
import pytest
from console import BIN, SECONDS, document, good, plogic
from jsonschema import Draft202012Validator
from small_frames import CAMERA, KB
from written_videos import pictures, video

from plogic.run.batch.frames import Settings
from plogic.run.cameras import GivenCamera
from plogic.run.watch.moments import Moment
from plogic.run.watch.watcher import Watcher

SMALL = pictures(4)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A folder with a camera, a video of four small frames, and the same as PNG in a row."""
    root = tmp_path_factory.mktemp("small")
    (root / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    video(root / "clip.avi", SMALL)
    (root / "row.bin").write_bytes(b"".join(map(png, SMALL)))
    return root


def png(pixels):
    return cv2.imencode(".png", pixels)[1].tobytes()


def watching(cwd, *arguments, kb=KB):
    return [str(BIN / "plogic"), "watch", *map(str, arguments), "--kb", str(kb), "--camera", "camera.json"], cwd


def piped(data, cwd, *arguments, kb=KB):
    command, cwd = watching(cwd, "-", *arguments, kb=kb)
    return subprocess.run(command, cwd=cwd, input=data, capture_output=True, timeout=SECONDS, check=False)


def rows_of(text):
    return [json.loads(line) for line in text.splitlines()]


def test_each_line_is_what_perceive_writes_of_the_picture_and_its_moment(towers):
    lines = good("watch", "clip.mkv", "--kb", "towers", "--camera", "camera.json", cwd=towers).splitlines()
    moments = [(row["moment"]["number"], row["moment"]["seconds"]) for row in map(json.loads, lines)]
    assert moments == [(0, 0.0), (1, 0.1), (2, 0.2)]
    for number, line in enumerate(lines):
        row = json.loads(line)
        assert row.pop("moment") == {"input": "clip.mkv", "number": number, "seconds": number / 10, "skipped": 0}
        picture = f"pictures/clip_{number:06d}.png"
        alone = document("perceive", picture, "--kb", "towers", "--camera", "camera.json", cwd=towers)
        assert json.dumps(row) == json.dumps(alone)


def test_a_line_is_asked_as_any_interpretation(towers):
    line = good("watch", "clip.mkv", "--limit", 1, "--kb", "towers", "--camera", "camera.json", cwd=towers)
    asked = json.loads(good("query", "-", "object(X, T)", "--json", stdin=line))
    assert {answer["goal"].partition(",")[2].strip(" )") for answer in asked["answers"]} == {"t1", "t2"}


def test_lines_fit_their_schemas(small):
    spoilt = png(SMALL[0]) + png(SMALL[1])[:-30] + b"\0" * 60 + png(SMALL[2])
    rows = rows_of(piped(spoilt, small).stdout) + rows_of(piped(png(SMALL[0]), small, "--short").stdout)
    assert [row["format"] for row in rows] == ["interpretation/1", "frame/1", "interpretation/1", "frame/1"]
    for row in rows:
        schema = json.loads(good("schema", row["format"].partition("/")[0]))
        assert "moment" in row
        assert list(Draft202012Validator(schema).iter_errors(row)) == []


def test_pictures_on_stdin_give_the_same_bytes_again_and_those_of_a_file(small):
    data = (small / "row.bin").read_bytes()
    first, second = piped(data, small), piped(data, small)
    assert first.returncode == 0, first.stderr
    assert first.stdout == second.stdout
    of_file = good("watch", "row.bin", "--kb", KB, "--camera", "camera.json", cwd=small)
    assert of_file == first.stdout.decode().replace('"input":"-"', '"input":"row.bin"')
    assert [row["moment"]["seconds"] for row in rows_of(of_file)] == [None] * 4


def test_every_second_frame_and_no_more_than_the_limit(small):
    numbers = [
        row["moment"]["number"] for row in rows_of(piped((small / "row.bin").read_bytes(), small, "--every", 2).stdout)
    ]
    assert numbers == [0, 2]
    of_video = good("watch", "clip.avi", "--every", 3, "--limit", 1, "--kb", KB, "--camera", "camera.json", cwd=small)
    assert [row["moment"]["number"] for row in rows_of(of_video)] == [0]


def test_the_end_is_one_line_with_counts_and_speed(small):
    said = piped((small / "row.bin").read_bytes(), small).stderr.decode()
    assert said.splitlines()[-1].startswith("4 frames; ")
    assert said.splitlines()[-1].endswith(" frames a second")


def test_a_damaged_picture_is_a_line_and_no_stop(small):
    spoilt = png(SMALL[0]) + png(SMALL[1])[:-30] + b"\0" * 60 + png(SMALL[2])
    done = piped(spoilt, small, "--short")
    assert [row["status"] for row in rows_of(done.stdout)] == ["done", "error", "done"]
    assert "<stdin>: picture 1: the PNG file is damaged" in done.stderr.decode()
    assert done.returncode == 1


def test_pictures_are_those_of_perceive(towers, tmp_path):
    options = ["--kb", "towers", "--camera", "camera.json"]
    good("watch", "clip.mkv", *options, "--picture", tmp_path / "now.png", "--pictures", tmp_path / "all", cwd=towers)
    good("perceive", "pictures/clip_000002.png", *options, "--picture", tmp_path / "alone.png", cwd=towers)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["all", "alone.png", "now.png"]
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == [f"clip_{n:06d}.png" for n in range(3)]
    assert (tmp_path / "now.png").read_bytes() == (tmp_path / "alone.png").read_bytes()
    assert (tmp_path / "all" / "clip_000002.png").read_bytes() == (tmp_path / "alone.png").read_bytes()


def test_frames_before_the_damage_are_written(towers):
    done = plogic("watch", "cut_clip.mkv", "--kb", "towers", "--camera", "camera.json", cwd=towers)
    assert [row["moment"]["number"] for row in rows_of(done.stdout)] == [0]
    assert done.stderr.splitlines()[-1].startswith("plogic: cut_clip.mkv: is damaged or cut off after 1 frame: ")
    assert done.returncode == 1


def test_a_reader_that_goes_ends_it_quietly(small):
    data = (small / "row.bin").read_bytes() * 40
    *aside, _ = piped(png(SMALL[0]), small).stderr.splitlines(keepends=True)  # of the knowledge base
    aside = b"".join(aside)
    command, cwd = watching(small, "-")
    with subprocess.Popen(
        command, cwd=cwd, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as child:
        feeder = os.fork()
        if feeder == 0:
            try:
                os.close(child.stdout.fileno())
                child.stdin.write(data)
            finally:
                os._exit(0)
        child.stdin.close()
        assert json.loads(child.stdout.readline())["moment"]["number"] == 0
        child.stdout.close()
        assert child.wait(SECONDS) == 0
        assert child.stderr.read() == aside
        os.waitpid(feeder, 0)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 1), (signal.SIGTERM, 143)], ids=["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("how", ["stdin", "newest", "pipe", "one job"])
def test_ctrl_c_ends_it_with_a_line(small, tmp_path, how, number, status):
    os.mkfifo(tmp_path / "pipe")
    source = {"pipe": [tmp_path / "pipe"], "newest": ["-", "--newest"], "one job": ["-", "--jobs", 1]}.get(how, ["-"])
    command, cwd = watching(small, *source)
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=cwd, stdin=pipe, stdout=pipe, stderr=pipe) as child:
        feeder = (tmp_path / "pipe").open("wb") if how == "pipe" else child.stdin
        feeder.write(png(SMALL[0]))
        feeder.flush()
        assert json.loads(child.stdout.readline())["moment"]["number"] == 0
        child.send_signal(number)
        assert child.wait(SECONDS) == status  # nothing more has come
        said = child.stderr.read().decode()
        feeder.close()
    assert said.splitlines()[-1].startswith("stopped: 1 frame; ")
    assert "Traceback" not in said


def test_a_later_picture_of_another_size_is_a_line_and_no_stop(small):
    mixed = png(SMALL[0]) + png(pictures(1, 32, 32)[0]) + png(SMALL[2])
    done = piped(mixed, small, "--short")
    assert [row["status"] for row in rows_of(done.stdout)] == ["done", "error", "done"]
    assert "the camera is 64x48" in done.stderr.decode()
    assert done.returncode == 1


REFUSED = {
    "text": (b"this is no picture", [], "<stdin>: has no JPEG, PNG or PNM picture"),
    "nothing": (b"", [], "<stdin>: has no frame"),
    "a container": (b"\x1aE\xdf\xa3" + bytes(90), [], "<stdin>: is a video (Matroska) and no stream of pictures"),
    "another size": (png(pictures(1, 32, 32)[0]), [], "the camera is 64x48"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_watched_is_told(small, case):
    data, arguments, said = REFUSED[case]
    done = piped(data, small, *arguments)
    assert (done.returncode, done.stdout) == (1, b"")
    assert said in done.stderr.decode().splitlines()[-1]


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("7", "camera 7: there is no such camera, or it is in use"),
        ("rtsp://here/cam", "ffmpeg -i rtsp://here/cam -f image2pipe"),
        (".", "is a folder: plogic batch"),
        ("none.mp4", "none.mp4: is missing"),
    ],
)
def test_a_source_that_cannot_be_opened_says_what_to_do(small, source, said):
    done = plogic("watch", source, "--kb", KB, "--camera", "camera.json", cwd=small)
    assert (done.returncode, done.stdout) == (1, "")
    assert said in done.stderr.splitlines()[-1]


def test_a_frame_at_which_we_fail_is_a_line_and_no_stop(small):
    watcher = Watcher(Settings(str(KB), GivenCamera(str(small / "camera.json"))), "-", short=True)
    perceive, failing = watcher.perceiver, Moment(1, None, SMALL[1])

    def fails_once(gamma, options, image, clock):
        if image is failing.pixels:
            raise ZeroDivisionError("by\nzero")
        return perceive(gamma, options, image, clock)

    fails_once.kb = perceive.kb
    watcher.perceiver = fails_once
    rows = [
        json.loads(watcher(moment).line) for moment in (Moment(0, None, SMALL[0]), failing, Moment(2, None, SMALL[2]))
    ]
    assert [row["status"] for row in rows] == ["done", "error", "done"]
    assert rows[1]["error"] == "internal error: ZeroDivisionError: by zero"


def test_newest_is_of_a_stream(small):
    done = plogic("watch", "clip.avi", "--newest", "--kb", KB, "--camera", "camera.json", cwd=small)
    assert done.returncode == 2
    assert Path(small / "clip.avi").is_file()
