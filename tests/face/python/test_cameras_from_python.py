"""Cameras as a user of Python has them: of any file, by numbers, by a field of view."""

from __future__ import annotations

import json

import numpy as np
import pytest
from exif_files import EQUIVALENT, exif, grey, jpeg

import plogic
from geometry.camera import camera_to_dict
from plogic import Camera


def test_a_camera_of_any_format_loads(tmp_path):
    ours = Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])
    (tmp_path / "ours.json").write_text(json.dumps(camera_to_dict(ours)))
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 640 480 600 600 320.5 240.5\n")
    (tmp_path / "ros.yaml").write_text(
        "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [600, 0, 320, 0, 600, 240, 0, 0, 1]}\n"
    )
    assert [Camera.load(tmp_path / name) == ours for name in ("ours.json", "cameras.txt", "ros.yaml")] == [True] * 3


def test_a_camera_of_many_is_told_by_its_picture(tmp_path):
    (tmp_path / "cameras.txt").write_text("1 PINHOLE 64 48 60 60 32 24\n2 PINHOLE 64 48 70 70 32 24\n")
    (tmp_path / "images.txt").write_text("1 1 0 0 0 0 0 0 2 a.png\n\n")
    assert Camera.load(tmp_path, photo="shots/a.png").f == 70
    assert Camera.load(tmp_path, 1).f == 60
    with pytest.raises(plogic.Error, match="say which camera: 1, 2"):
        Camera.load(tmp_path)


def test_a_camera_takes_its_lens_and_its_place():
    pose = np.eye(4)
    camera = Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]], [0.1, 0, 0, 0], pose)
    assert camera.dist.tolist() == [0.1, 0, 0, 0]
    assert camera.world_from_camera.tolist() == pose.tolist()
    assert camera != Camera(640, 480, [[600, 0, 320], [0, 600, 240], [0, 0, 1]])
    with pytest.raises(plogic.Error, match=r"camera\.K"):
        Camera(640, 480, [[600, 0], [0, 600]])


@pytest.mark.parametrize(("name", "half", "side"), [("horizontal", 30.0, 640), ("vertical", 20.0, 480)])
def test_a_field_of_view_reaches_the_edges_of_the_image(name, half, side):
    camera = Camera.from_fov(640, 480, **{name: 2 * half})
    axis = int(name == "vertical")
    uv = [319.5, 239.5]
    uv[axis] = side - 0.5
    assert np.degrees(np.arctan(camera.normalised(uv)[axis])) == pytest.approx(half)
    assert camera.K[0, 0] == camera.K[1, 1]


def test_a_field_of_view_reaches_the_corners_of_the_image():
    camera = Camera.from_fov(640, 480, diagonal=80)
    corner = np.linalg.norm(camera.normalised([639.5, 479.5]))
    assert np.degrees(np.arctan(corner)) == pytest.approx(40)


def test_a_photo_without_a_camera_takes_exif_s_and_a_warning_says_so(tmp_path):
    (tmp_path / "phone.jpg").write_bytes(jpeg(grey(64, 48), exif({EQUIVALENT: 28})))
    with pytest.warns(UserWarning, match=r"phone\.jpg: camera guessed from EXIF: 28 mm equivalent") as caught:
        gamma = plogic.detect(tmp_path / "phone.jpg", "towers")
    assert gamma.camera.f == pytest.approx(80 * 28 / 43.266615)
    with pytest.warns(UserWarning, match="guessed") as again:
        scene = plogic.perceive(str(tmp_path / "phone.jpg"), "towers")
    assert scene.document["camera"]["K"][0][0] == pytest.approx(gamma.camera.f)
    assert [warning.filename for warning in (*caught, *again)] == [__file__] * 2


def test_pixels_have_no_exif(tmp_path):
    with pytest.raises(plogic.Error, match=r"the image: an image needs its camera: give a Camera \(Camera\.from_fov"):
        plogic.detect(grey(64, 48), "towers")


@pytest.mark.parametrize(
    "wrong",
    [{}, {"horizontal": 60, "vertical": 40}, {"vertical": 40, "diagonal": 60}, {"horizontal": 0}, {"vertical": 180}],
)
def test_a_field_of_view_that_is_none(wrong):
    with pytest.raises(plogic.Error, match="from_fov"):
        Camera.from_fov(640, 480, **wrong)
