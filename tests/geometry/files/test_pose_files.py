"""Where a moving camera stood, read from files."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geometry.errors import CameraError
from geometry.files.pose_files import read_poses

POSE = np.array([[0.0, -1.0, 0.0, 1.5], [1.0, 0.0, 0.0, -2.0], [0.0, 0.0, 1.0, 0.25], [0.0, 0.0, 0.0, 1.0]])


def written(tmp_path, text):
    path = tmp_path / "poses"
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return path


def listed(*frames):
    return {"format": "poses/1", "frames": list(frames)}


def test_our_own_format(tmp_path):
    frames = {"frame": "a.png", "T_world_camera": POSE.tolist()}, {"frame": None, "T_world_camera": np.eye(4).tolist()}
    one, ahead = read_poses(written(tmp_path, listed(*frames)))
    assert (one.frame, ahead.frame) == ("a.png", None)
    assert np.array_equal(one.world_from_camera, POSE)
    assert np.array_equal(ahead.world_from_camera, np.eye(4))


def test_a_tum_trajectory_says_the_same(tmp_path):
    half = np.sqrt(0.5)
    (placed,) = read_poses(
        written(
            tmp_path, f"# timestamp tx ty tz qx qy qz qw\n\n1305031102.17 1.5 -2 0.25 0 0 {half} {half}  # a remark\n"
        )
    )
    assert placed.frame == "1305031102.17"
    assert np.allclose(placed.world_from_camera, POSE)


def test_rounded_matrices_are_taken_for_the_nearest_rotation(tmp_path):
    rough = POSE + np.pad(np.random.default_rng(0).uniform(-2e-4, 2e-4, (3, 3)), ((0, 1), (0, 1)))
    (placed,) = read_poses(written(tmp_path, listed({"frame": "a", "T_world_camera": rough.tolist()})))
    R = placed.world_from_camera[:3, :3]
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.abs(R - POSE[:3, :3]).max() < 1e-3


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "holds no pose"),
        (listed(), ":1:33: frames: a list of 0, and not of 1"),
        ({"format": "poses/2", "frames": []}, "should be"),
        ("{", "is no JSON"),
        (listed({"frame": "a"}), "frames.0.T_world_camera: is missing: should be a rigid 4x4"),
        (listed({"frame": 3, "T_world_camera": POSE.tolist()}), "frames.0.frame"),
        (listed({"frame": "a", "T_world_camera": (2 * POSE).tolist()}), "frames.0.T_world_camera: should be a rigid"),
        (listed({"frame": "a", "T_world_camera": [[1, 2], [3]]}), "frames.0.T_world_camera: should be a rigid"),
        (listed({"frame": "a", "T_world_camera": "x"}), "frames.0.T_world_camera: should be a rigid"),
        ("a 1 2 3 0 0 0 2\n", ":1: must be 'name tx"),
        ("a 1 2 3 0 0 0\n", ":1: must be 'name tx"),
        ("a 1 2 3 0 0 x 1\n", ":1: must be 'name tx"),
        ("a 1 2 nan 0 0 0 1\n", ":1: must be 'name tx"),
    ],
)
def test_mistakes_are_told(tmp_path, content, words):
    with pytest.raises(CameraError, match="poses") as caught:
        read_poses(written(tmp_path, content))
    assert words in str(caught.value)


def test_all_mistakes_are_told_at_once(tmp_path):
    with pytest.raises(CameraError) as caught:
        read_poses(written(tmp_path, "a 1 2\nb 0 0 0 0 0 0 1\nc 1\n"))
    assert [line.split(":")[1] for line in str(caught.value).splitlines()] == ["1", "3"]


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(CameraError, match="is missing"):
        read_poses(tmp_path / "none")


def test_no_text_is_told(tmp_path):
    path = tmp_path / "poses"
    path.write_bytes(b"\xff\xfe\x00 1 2")
    with pytest.raises(CameraError, match="no UTF-8"):
        read_poses(path)
