"""Cameras as a user of Python has them: of any file, by numbers, by a field of view."""

from __future__ import annotations

import json

import numpy as np
import pytest

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


@pytest.mark.parametrize("wrong", [{}, {"horizontal": 60, "vertical": 40}, {"horizontal": 0}, {"vertical": 180}])
def test_a_field_of_view_that_is_none(wrong):
    with pytest.raises(plogic.Error, match="from_fov"):
        Camera.from_fov(640, 480, **wrong)
