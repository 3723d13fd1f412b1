"""A file of moves: read whole, or refused in a line that says where and what."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.files.pose_files import read_moves
from geometry.frames import inverse, look_at

WORLD = inverse(look_at((3.0, 1.0, 2.0), (0.0, 0.0, 0.5)))
MOVED = inverse(look_at((0.5, 0.2, 0.1), (0.0, 0.0, 4.0), (0, -1, 0)))


def _written(tmp_path, document):
    (tmp_path / "moves.json").write_text(document if isinstance(document, str) else json.dumps(document))
    return tmp_path / "moves.json"


def test_moves_in_either_frame_come_to_the_same_place(tmp_path):
    rows = [{"name": "a", "T_present_candidate": MOVED.tolist()}, {"T_world_camera": (WORLD @ MOVED).tolist()}]
    first, second = read_moves(_written(tmp_path, {"format": "moves/1", "moves": rows}))
    assert (first.name, second.name) == ("a", "move 2")
    assert np.allclose(first.world(WORLD), second.world(WORLD))
    assert np.allclose(first.present(WORLD), second.present(WORLD))


def test_poses_of_a_sequence_are_moves(tmp_path):
    rows = [{"frame": "f.png", "T_world_camera": WORLD.tolist()}]
    (move,) = read_moves(_written(tmp_path, {"format": "poses/1", "frames": rows}))
    assert move.name == "f.png"
    assert np.allclose(move.present(WORLD), np.eye(4))


def test_a_place_in_the_world_needs_to_know_where_the_camera_is(tmp_path):
    (move,) = read_moves(_written(tmp_path, {"format": "moves/1", "moves": [{"T_world_camera": WORLD.tolist()}]}))
    with pytest.raises(GeometryError, match="T_present_candidate"):
        move.present(None)


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ("{", "JSON"),
        (
            {"format": "other/1", "moves": [{"T_world_camera": np.eye(4).tolist()}]},
            ":1:12: format: 'other/1' should be 'moves/1'",
        ),
        ({"format": "moves/1", "moves": []}, ":1:32: moves: a list of 0, and not of 1"),
        ({"format": "moves/1", "moves": [{}]}, r"moves\.0: .*one of"),
        ({"format": "moves/1", "moves": [{"T_world_camera": [[1]]}]}, r"moves\.0\.T_world_camera: should be a rigid"),
        ({"format": "moves/1", "moves": [{"T_present_candidate": np.diag([2, 1, 1, 1]).tolist()}]}, "rigid"),
    ],
)
def test_what_is_no_file_of_moves_is_refused(tmp_path, document, told):
    with pytest.raises(GeometryError, match=told) as error:
        read_moves(_written(tmp_path, document))
    assert "moves.json" in str(error.value)
    assert len(str(error.value).splitlines()) == 1
