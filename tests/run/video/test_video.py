"""Videos: every pixel of a lossless one, and one line for what is wrong with any."""

from __future__ import annotations

import os
import signal
import struct

import numpy as np
import pytest
from written_videos import RATE, cut, pictures, video

from plogic.base.errors import InputError
from plogic.run.cameras import GivenCamera
from plogic.run.video import video as videos
from plogic.run.video.video import Count, Video, counted, frame_name, is_video
from plogic.run.video.views import views_in

FRAMES = pictures(6)


@pytest.mark.parametrize("ending", ["mkv", "avi"])
def test_a_lossless_video_has_the_pixels_of_its_pictures(tmp_path, ending):
    with Video(video(tmp_path / f"clip.{ending}", FRAMES)) as clip:
        for number in (0, 1, 5, 2, 4):  # 2: starts anew
            shown = clip.frame(number)
            assert np.array_equal(shown.pixels, FRAMES[number])
            assert shown.seconds == pytest.approx(number / RATE)
        assert clip.frame(6) is None
        assert (clip.width, clip.height, clip.rotation) == (64, 48, 0)


@pytest.mark.parametrize(("name", "code"), [("a.mkv", "FFV1"), ("b.avi", "FFV1"), ("c.mp4", "mp4v"), ("d.mov", "MJPG")])
def test_all_frames_are_counted(tmp_path, name, code):
    assert counted(video(tmp_path / name, FRAMES, code)) == Count(6, None)


@pytest.mark.parametrize(("name", "share"), [("a.mkv", 0.55), ("b.avi", 0.65)])
def test_of_a_video_that_was_cut_off_the_frames_before_are_kept(tmp_path, name, share):
    path = cut(video(tmp_path / name, FRAMES), share)
    frames, fault = counted(path)
    assert frames == 3
    assert fault.startswith(f"{path}: is damaged or cut off after 3 frames: ")
    with Video(path) as clip:
        assert np.array_equal(clip.frame(2).pixels, FRAMES[2])
        with pytest.raises(InputError, match="cut off after 3 frames"):
            clip.frame(3)


def test_a_damaged_frame_ends_a_video(tmp_path):
    path = video(tmp_path / "a.mkv", pictures(12, 320, 240), "mp4v")
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 4000] = np.random.default_rng(0).integers(0, 256, 4000).astype(np.uint8).tobytes()
    path.write_bytes(data)
    frames, fault = counted(path)
    assert 3 <= frames < 9
    assert f"after {frames} frames" in fault
    assert "\n" not in fault


WRONG = {
    "text.mp4": (b"hello, this is a text\n" * 50, "no video that is known by its first bytes"),
    "list.mkv": (b"#EXTM3U\n#EXTINF:1,\nfile:///etc/passwd\n", "no video that is known by its first bytes"),
    "empty.mp4": (b"", "is empty"),
    "head.mkv": (
        bytes.fromhex("1a45dfa3a34286810142f7810142f2810442f381084282886d6174726f736b61"),
        "no picture can be",
    ),
    "box.mp4": (b"\0\0\0\x18ftypisom\0\0\2\0isomiso2" + bytes(90), "no picture can be decoded"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_video_is_told_in_one_line(tmp_path, name):
    (tmp_path / name).write_bytes(WRONG[name][0])
    frames, fault = counted(tmp_path / name)
    assert frames == 0
    assert fault.startswith(f"{tmp_path / name}: ")
    assert WRONG[name][1] in fault
    assert "\n" not in fault


def test_an_mp4_without_its_end_says_that_the_recording_was_not_finished(tmp_path):
    path = cut(video(tmp_path / "a.mp4", FRAMES, "mp4v"), 0.5)
    assert counted(path).fault.endswith("the end of the recording is missing, and its index with it")


def test_frames_that_are_too_large_are_refused_before_they_are_decoded(tmp_path):
    path = video(tmp_path / "large.avi", [np.zeros((8000, 8008, 3), np.uint8)], "MJPG")
    assert "8008x8000 pixels, not 1 to 64000000" in counted(path).fault


def test_a_pipe_and_a_folder_are_no_videos(tmp_path):
    os.mkfifo(tmp_path / "pipe.mp4")
    assert "pipe or a device" in counted(tmp_path / "pipe.mp4").fault
    assert "folder" in counted(tmp_path).fault


def test_of_more_frames_than_are_read_it_is_said_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(videos, "MOST_FRAMES", 5)
    frames, fault = counted(video(tmp_path / "a.mkv", FRAMES))
    assert (frames, "more than the 5 frames" in fault, "cut it" in fault) == (0, True, True)


def test_a_decoder_that_dies_is_told(tmp_path):
    with Video(video(tmp_path / "a.mkv", FRAMES)) as clip:
        clip.frame(1)
        os.kill(clip._child.pid, signal.SIGKILL)
        with pytest.raises(InputError, match=r"the decoder dies after 2 frames \(signal 9\)"):
            clip.frame(5)


def turned(path):
    """The video with a matrix in its track's header that turns it by 90 degrees."""
    data = bytearray(path.read_bytes())
    at = data.index(b"tkhd") + 4 + 40
    upright = struct.unpack_from(">9i", data, at)
    assert upright == (65536, 0, 0, 0, 65536, 0, 0, 0, 1 << 30)
    struct.pack_into(">9i", data, at, 0, 65536, 0, -65536, 0, 0, 0, 0, 1 << 30)
    path.write_bytes(data)
    return path


def test_a_rotation_tag_is_not_applied_and_that_is_noted(tmp_path):
    upright = video(tmp_path / "a.mp4", FRAMES, "mp4v")
    with Video(upright) as clip:
        assert clip.notes == ()
        pixels = clip.frame(3).pixels
    (view, *_) = views_in([str(turned(upright))], every=3)[1:]
    shot = view.shot(GivenCamera(focal=60.0))
    assert np.array_equal(shot.image, pixels)
    (note,) = shot.notes
    assert note.startswith("its rotation tag (90 degrees) is not applied")
    assert note.endswith("64x48")


def test_pixels_that_cannot_be_read_are_told_with_a_remedy(tmp_path, monkeypatch):
    said = "its pixels cannot be read: Cannot convert interlaced to progressive frames"
    with Video(video(tmp_path / "a.mkv", FRAMES)) as clip:
        asked = clip._asked
        monkeypatch.setattr(clip, "_asked", lambda line: {"fault": said} if line == "take" else asked(line))
        with pytest.raises(InputError, match=f"a.mkv: frame 2: {said} .*-vf yadif"):
            clip.frame(2)


def test_frames_are_called_as_pictures_would_be():
    assert frame_name("videos/clip.mp4", 12) == "clip_000012"
    assert is_video("A.MP4")
    assert not is_video("a.png")


def test_views_of_one_world_are_files_and_frames_and_not_too_many(tmp_path, monkeypatch):
    path = str(video(tmp_path / "a.mkv", FRAMES))
    views = views_in(["b.png", path], every=4)
    assert [(view.name, view.number) for view in views] == [("b.png", 0), ("a_000000", 0), ("a_000004", 4)]
    assert np.array_equal(views[2].shot(GivenCamera(focal=60.0)).image, FRAMES[4])
    monkeypatch.setattr("plogic.run.video.views.MOST_VIEWS", 2)
    with pytest.raises(InputError, match="give --every 3"):
        views_in([path], every=1)
