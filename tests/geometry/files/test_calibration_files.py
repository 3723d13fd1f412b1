"""Calibrations of ROS as its tools print them, and what of a printed topic is no camera."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.errors import CameraError
from geometry.files.camera_files import read_camera

ROS1 = """header: 
  seq: 7
  stamp: 
    secs: 1700000000
    nsecs:         5
  frame_id: "front"
height: 480
width: 640
distortion_model: "plumb_bob"
D: [-0.25, 0.08, 0.001, -0.002, 0.01]
K: [600.0, 0.0, 320.0, 0.0, 590.0, 240.0, 0.0, 0.0, 1.0]
R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
P: [600.0, 0.0, 320.0, 0.0, 0.0, 590.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi: 
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: False
---
"""  # noqa: W291 - as genpy 0.6.16 prints it
ROS2 = """header:
  stamp:
    sec: 1700000000
    nanosec: 5
  frame_id: front
height: 480
width: 640
distortion_model: plumb_bob
d:
- -0.25
- 0.08
- 0.001
- -0.002
- 0.01
k:
- 600.0
- 0.0
- 320.0
- 0.0
- 590.0
- 240.0
- 0.0
- 0.0
- 1.0
r:
- 1.0
- 0.0
- 0.0
p:
- 600.0
- 0.0
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
---
"""
LOST = "A message was lost!!!\n\ttotal count change:1\n\ttotal count: 1---\n"
"""What ros2 topic echo prints where the network is slow."""
K2 = ROS2[ROS2.index("k:") : ROS2.index("\nr:\n") + 1]
NUMBERS = "[600.0, 0.0, 320.0, 0.0, 590.0, 240.0, 0.0, 0.0, 1.0]"


def later(message, seconds=1700000001):
    return message.replace("1700000000", str(seconds))


def read(folder, text):
    (folder / "info.yaml").write_text(text)
    return read_camera(folder / "info.yaml")


@pytest.mark.parametrize(
    "text",
    [
        ROS1,
        ROS2,
        ROS1 + later(ROS1) + later(ROS1, 1700000002),
        ROS2 + later(ROS2)[:200],  # Ctrl-C
        ROS2 + later(ROS2)[:30],
        ROS1.removesuffix("---\n"),
        "---\n" + ROS2,
        ROS2.replace(K2, f"k: {NUMBERS}\n"),
        ROS2.replace(K2, f"k: array('d', {NUMBERS})\n"),
        ROS2.replace(K2, f"k: \"array('d', {NUMBERS})\"\n"),
        ROS2.replace(K2, "k: array([600.,   0., 320.,   0., 590., 240.,\n    0., 0., 1.])\n"),
        ROS2.replace("\n", "\r\n"),
        ROS2 + LOST,
        ROS2 + LOST + later(ROS2),
        ROS2.removesuffix("---\n") + LOST,
        ROS2 + "[WARN] [1700000000.1] [ros2cli]: the topic has: no more publishers\n",
        "WARNING: topic [/camera_info] does not appear to be published yet\n" + ROS2,
        "[INFO] [launch]: started: now\n" + ROS1 + "---\n",
    ],
)
def test_a_printed_topic_is_a_camera(tmp_path, text):
    camera = read(tmp_path, text)
    assert (camera.width, camera.height) == (640, 480)
    assert camera.K.tolist() == [[600, 0, 320], [0, 590, 240], [0, 0, 1]]
    assert camera.dist.tolist() == [-0.25, 0.08, 0.001, -0.002, 0.01]


def test_binning_and_region_are_those_of_the_pictures_that_are_sent(tmp_path):
    text = ROS1.replace("binning_x: 0", "binning_x: 2").replace("binning_y: 0", "binning_y: 4")
    text = text.replace("x_offset: 0", "x_offset: 100").replace("y_offset: 0", "y_offset: 40")
    camera = read(tmp_path, text.replace("  height: 0\n  width: 0", "  height: 400\n  width: 500"))
    whole, points = read(tmp_path, ROS1), np.array([[0.1, 0.2, 2], [-0.2, 0.1, 1.5]])
    assert (camera.width, camera.height) == (250, 100)
    edges = whole.project(points) + 0.5 - [100, 40]  # from the region's outer edge, where pixels are joined evenly
    assert camera.project(points) == pytest.approx(edges / [2, 4] - 0.5, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            ROS2.replace("- 320.0\n", "- '...'\n"),
            r"is cut off \('\.\.\.'\): print it whole, ros2 topic echo --full-length",
        ),
        (ROS1.replace(NUMBERS, "[600.0, 0.0, '...']"), ":11: camera_matrix: is cut off"),
        (ROS2.replace(K2, "k: array('d', [600.0, ...])\n"), "camera_matrix: is cut off"),
        (ROS2.replace("- 0.001\n", "- '...'\n"), "distortion_coefficients: is cut off"),
        (
            ROS1.replace(NUMBERS, str([0.0] * 9)),
            "camera_matrix: is all zeros, as a driver says that has no calibration",
        ),
        (ROS1.replace("plumb_bob", "equidistant"), "rectify the pictures"),
        (ROS1 + later(ROS1).replace("590.0", "591.0"), "holds messages of different cameras"),
        (ROS2[:150], "camera_matrix: is missing"),
        (later(ROS1) + "WARNING: late\n" + ROS1.replace("590.0", "x"), ":34: camera.K: must be a 3x3 matrix"),
        (ROS1.replace("  width: 0", "  width: -1"), ":20: roi.width: must be a whole number from 0, not -1"),
        (ROS1.replace("binning_x: 0", "binning_x: -1"), ":14: binning_x: must be a whole number from 0"),
        (ROS1.replace("binning_x: 0", "binning_x: 641"), "camera.width"),
        (ROS1.replace("binning_x: 0", "binning_x: 2").replace("600.0, 0.0, 320.0", "a, b, c"), "must be numbers"),
        (ROS1 + "a: [", ":23: is not plain YAML"),
        ("---\n" * 1000, "must be a camera"),
    ],
)
def test_what_is_no_camera_of_a_topic_is_one_line(tmp_path, text, message):
    with pytest.raises(CameraError, match=message) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "info.yaml"))
    assert "\n" not in str(caught.value)
