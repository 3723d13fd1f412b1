"""``plogic batch`` and ``plogic perceive`` of a video, as of the pictures that it is made of."""

from __future__ import annotations

import hashlib
import json

import pytest
from console import document, good, plogic


def lines_of(text):
    return [json.loads(line) for line in text.splitlines()]


def without_names(line):
    """A line's text without which frame it is of."""
    row = json.loads(line)
    for key in ("input", "frame", "sha256"):
        del row[key]
    return json.dumps(row)


@pytest.mark.parametrize("full", [(), ("--full",)], ids=["short", "full"])
def test_a_lossless_video_gives_the_bytes_of_its_pictures(towers, full):
    of_pictures = good("batch", "pictures", "--kb", "towers", "--jobs", 1, *full, cwd=towers)
    of_video = good("batch", "clip.mkv", "--kb", "towers", "--jobs", 2, *full, cwd=towers)
    assert [(row["input"], row["frame"]) for row in lines_of(of_video)] == [
        ("clip.mkv", f"clip_{number:06d}") for number in range(3)
    ]
    assert [*map(without_names, of_video.splitlines())] == [*map(without_names, of_pictures.splitlines())]
    if full:
        bodies = [
            [line.partition('"interpretation":')[2] for line in text.splitlines()] for text in (of_video, of_pictures)
        ]
        assert bodies[0] == bodies[1]
        assert all(bodies[0])


def test_the_sha256_is_of_the_video_and_its_camera(towers):
    (line,) = lines_of(good("batch", "clip.mkv", "--every", 3, "--kb", "towers", cwd=towers))
    read = (towers / "clip.mkv").read_bytes() + (towers / "camera.json").read_bytes()
    assert line["sha256"] == hashlib.sha256(read).hexdigest()


def test_every_second_frame_and_on_after_a_kill(towers, tmp_path):
    command = ["batch", "clip.mkv", "--every", 2, "--kb", "towers", "-o", tmp_path / "out.jsonl"]
    good(*command, cwd=towers)
    whole = (tmp_path / "out.jsonl").read_bytes()
    assert [row["frame"] for row in lines_of(whole.decode())] == ["clip_000000", "clip_000002"]
    (tmp_path / "out.jsonl").write_bytes(whole[: whole.index(b"\n") + 100])
    good(*command, "--resume", cwd=towers)
    assert (tmp_path / "out.jsonl").read_bytes() == whole


def test_a_video_that_was_cut_off_gives_the_frames_before(towers):
    done = plogic("batch", "cut_clip.mkv", "--kb", "towers", cwd=towers)
    first, last = lines_of(done.stdout)
    assert (first["frame"], first["status"]) == ("cut_clip_000000", "done")
    assert (last["frame"], last["status"]) == (None, "error")
    assert last["error"].startswith("cut_clip.mkv: is damaged or cut off after 1 frame: ")
    assert done.stderr.splitlines() == [last["error"], "2 frames, 1 bad"]
    assert done.returncode == 1


def test_a_video_without_a_camera_says_so(towers, tmp_path):
    (tmp_path / "clip.mkv").write_bytes((towers / "clip.mkv").read_bytes())
    done = plogic("batch", "clip.mkv", "--every", 3, "--kb", "towers", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("plogic: clip.mkv clip_000000: an image needs its camera: give --camera FILE")


def test_videos_in_a_folder_are_left_alone(towers):
    rows = lines_of(good("batch", "pictures", "--kb", "towers", cwd=towers))
    assert {row["frame"] for row in rows} == {None}
    done = plogic("batch", "c*.mkv", "--every", 3, "--kb", "towers", cwd=towers)
    assert [row["input"] for row in lines_of(done.stdout)] == ["clip.mkv", "cut_clip.mkv", "cut_clip.mkv"]


def test_perceive_takes_the_frames_as_views_of_one_world(towers):
    with_poses = ["--kb", "towers", "--camera", "camera.json", "--poses", "poses.json"]
    of_video = good("perceive", "clip.mkv", *with_poses, cwd=towers)
    frames = [f"shots/frame-00{number}/image.png" for number in range(3)]
    of_pictures = good("perceive", *frames, *with_poses, cwd=towers)
    for number, frame in enumerate(frames):
        of_pictures = of_pictures.replace(frame, f"clip_{number:06d}")
    assert of_video == of_pictures
    assert json.loads(of_video)["format"] == "panorama/1"


def test_perceive_writes_what_the_frames_before_the_damage_show(towers):
    poses = json.loads((towers / "poses.json").read_text())
    poses["frames"] = [{**poses["frames"][0], "frame": "cut_clip_000000"}]
    (towers / "one.json").write_text(json.dumps(poses))
    options = ["--kb", "towers", "--camera", "camera.json", "--poses", "one.json"]
    done = plogic("perceive", "cut_clip.mkv", *options, cwd=towers)
    assert [view["frame"] for view in json.loads(done.stdout)["views"]] == ["cut_clip_000000"]
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("plogic: cut_clip.mkv: is damaged or cut off after 1 frame: ")


REFUSED = {
    "without places": (["clip.mkv", "--camera", "camera.json"], "or take each frame by itself: plogic batch clip.mkv"),
    "a page": (["clip.mkv", "--camera", "camera.json", "--report", "page.html"], "--report: is made of one frame"),
    "a pair": (["clip.mkv", "clip.mkv", "--stereo", "camera.json"], "--stereo: takes pictures or Γ, and no video"),
    "missing": (["none.mkv", "--camera", "camera.json"], "none.mkv: is missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_perceive_cannot_make_of_a_video_is_told(towers, case):
    arguments, said = REFUSED[case]
    done = plogic("perceive", *arguments, "--kb", "towers", cwd=towers)
    assert (done.returncode, done.stdout) == (1, "")
    assert said in done.stderr.splitlines()[-1]


def test_one_picture_still_gives_one_interpretation(towers):
    one = document("perceive", "pictures/clip_000000.png", "--kb", "towers", "--camera", "camera.json", cwd=towers)
    assert one["format"] == "interpretation/1"
    assert "moment" not in one
