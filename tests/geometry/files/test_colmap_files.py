"""COLMAP's cameras against COLMAP: files that it wrote, and the pixels at which it sees points (``colmap/``)."""

from __future__ import annotations

import json
import shutil
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import CameraError, WhichCameraError
from geometry.files.camera_files import read_camera
from geometry.files.colmap_files import colmap_binary, taken_by

COLMAP = Path(__file__).with_name("colmap")
SEEN = json.loads((COLMAP / "pixels.json").read_text())
BINARY, TEXT = COLMAP / "binary", COLMAP / "text"
KINDS = pytest.mark.parametrize("kind", [BINARY, TEXT], ids=["binary", "text"])


@KINDS
@pytest.mark.parametrize("name", SEEN["pixels"])
def test_points_are_seen_where_colmap_sees_them(kind, name):
    theirs = np.array(SEEN["pixels"][name]) - 0.5  # a pixel's centre is at .5 there
    assert len(theirs) == 12
    assert read_camera(kind, name).project(SEEN["points_camera"]) == pytest.approx(theirs, abs=1e-9)


@KINDS
@pytest.mark.parametrize(
    ("photo", "name"),
    [("left/photo.jpg", "1"), ("/data/right/photo.jpg", "2"), ("two words.jpg", "3"), ("../x/o.jpg", "5")],
)
def test_a_photo_s_camera_is_found_by_its_name(kind, photo, name):
    for place in (kind, kind / f"cameras.{'bin' if kind == BINARY else 'txt'}"):
        assert read_camera(place, photo=photo).K.tolist() == read_camera(kind, name).K.tolist()


@KINDS
def test_a_name_that_tells_no_one_camera_is_an_error_that_lists_them(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # in a folder called `left` the first name would tell one
    for photo in ("photo.jpg", "strange.jpg"):
        with pytest.raises(
            WhichCameraError, match=r"has 7 cameras; say which camera: 1, 2, 3, 4, 5, 6, 7 \(FILE#1\)"
        ) as caught:
            read_camera(kind, photo=photo)
        assert str(caught.value).endswith(f"tells no one camera for {photo}")
    with pytest.raises(CameraError, match="has no camera 9; it has 1, 2"):
        read_camera(kind, 9)


@KINDS
def test_a_fisheye_lens_is_refused_with_what_to_do(kind):
    with pytest.raises(CameraError, match="not OPENCV_FISHEYE: undistort with colmap image_undistorter"):
        read_camera(kind, photo="fish.jpg")


def test_one_camera_is_that_of_any_photo(tmp_path):
    (tmp_path / "cameras.txt").write_text("3 PINHOLE 640 480 600 590 320.5 240.5\n")
    assert read_camera(tmp_path, photo="any.jpg").K[1].tolist() == [0, 590, 240]


@pytest.mark.parametrize("place", ["sparse/0", "sparse"])
def test_the_folder_of_a_project_stands_for_its_model(tmp_path, place):
    shutil.copytree(BINARY, tmp_path / place)
    assert read_camera(tmp_path, photo="o.jpg").dist.tolist()[:2] == [-0.25, 0.0625]


def test_binary_files_go_first(tmp_path):
    shutil.copytree(BINARY, tmp_path / "a")
    (tmp_path / "a/cameras.txt").write_text("nonsense")
    assert read_camera(tmp_path / "a", 1).f == 600


def test_a_folder_without_cameras(tmp_path):
    with pytest.raises(CameraError, match=r"is a folder without COLMAP's cameras\.bin or cameras\.txt"):
        read_camera(tmp_path)


@pytest.mark.parametrize(
    ("cameras", "message"),
    [
        (b"", "is cut off after 0 bytes"),
        (struct.pack("<Q", 2**63), "is cut off after 8 bytes"),
        (struct.pack("<Q", 0) + b"x", "has 1 bytes after its 0 cameras"),
        (struct.pack("<Q", 0), "has no camera"),
        (struct.pack("<QIiQQ3d", 1, 1, 99, 640, 480, 600, 320, 240), "model must be a number from 0 to 17, not 99"),
        (struct.pack("<QIiQQ3d", 1, 1, 0, 2**60, 480, 600, 320, 240), "camera.width"),
        (struct.pack("<QIiQQ3d", 1, 1, 0, 640, 480, float("nan"), 320, 240), "camera.K"),
        ((BINARY / "cameras.bin").read_bytes()[:-1], "is cut off"),
    ],
)
def test_a_wrong_binary_file_is_one_line(tmp_path, cameras, message):
    (tmp_path / "cameras.bin").write_bytes(cameras)
    with pytest.raises(CameraError, match=message) as caught:
        read_camera(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'cameras.bin'}: ")
    assert "\n" not in str(caught.value)


IMAGE = struct.pack("<I7dI", 1, 1, 0, 0, 0, 0, 0, 0, 1)


@pytest.mark.parametrize(
    ("name", "images", "message"),
    [
        ("images.bin", b"", "is no images.bin of COLMAP"),
        ("images.bin", struct.pack("<Q", 2**60), "pictures are more than the 1000000"),
        ("images.bin", struct.pack("<Q", 1) + IMAGE + b"a" * 9000, "a name must end within 4096 bytes"),
        ("images.bin", struct.pack("<Q", 1) + IMAGE + b"a.jpg\0" + struct.pack("<Q", 2**61), "points are too many"),
        ("images.txt", "# c\n\nnonsense\n", r"images\.txt:3: must be IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"),
        ("images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n" + "1 " * 100_000 + "\nnonsense", r"images\.txt:3: must be IMAGE_ID"),
    ],
)
def test_a_wrong_file_of_images_is_one_line(tmp_path, name, images, message):
    shutil.copytree(BINARY if name.endswith("bin") else TEXT, tmp_path / "a")
    (tmp_path / "a" / name).write_bytes(images if isinstance(images, bytes) else images.encode())
    with pytest.raises(CameraError, match=message) as caught:
        read_camera(tmp_path / "a", photo="p.jpg")
    assert str(caught.value).startswith(str(tmp_path / "a" / name))


def test_a_changed_file_of_images_is_read_again(tmp_path):
    shutil.copytree(TEXT, tmp_path / "a")
    assert read_camera(tmp_path / "a", photo="o.jpg").K[1, 1] == 590
    (tmp_path / "a/images.txt").write_text("1 1 0 0 0 0 0 0 4 o.jpg\n\n")
    assert read_camera(tmp_path / "a", photo="o.jpg").K[1, 1] == 600


@given(st.data())
@settings(max_examples=300, deadline=None)
def test_no_bytes_do_harm(data):
    whole = bytearray((BINARY / "cameras.bin").read_bytes())
    for at in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=6)):
        whole[at] = data.draw(st.integers(0, 255))
    try:
        cameras = colmap_binary(bytes(whole[: data.draw(st.integers(0, len(whole)))]))
    except CameraError:
        return
    assert len(cameras) <= 7


@pytest.mark.parametrize("kind", ["bin", "txt"])
def test_no_file_of_images_does_harm(kind, tmp_path):
    whole, rng = ((BINARY if kind == "bin" else TEXT) / f"images.{kind}").read_bytes(), np.random.default_rng(0)
    answers, told = set(), []
    for number in range(200):
        spoilt = bytearray(whole)
        for at in rng.integers(0, len(whole), rng.integers(1, 6)):
            spoilt[at] = rng.integers(0, 256)
        images = tmp_path / str(number) / f"images.{kind}"
        images.parent.mkdir()
        images.write_bytes(spoilt[: rng.integers(0, 2 * len(whole))])
        try:
            answers.add(taken_by(images.with_name(f"cameras.{kind}"), "o.jpg"))
        except CameraError as error:
            told.append((str(images), str(error)))
    assert "5" in answers
    assert len(told) > 20
    assert [text for images, text in told if not text.startswith(images) or "\n" in text] == []
