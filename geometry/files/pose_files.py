"""Where a moving camera stood: our ``poses/1``, or the lines of a TUM trajectory, ``name tx ty tz qx qy qz qw``.

``{"format": "poses/1", "frames": [{"frame": "f1.png", "T_world_camera": [[...], ...]}, {"frame": null,
"T_world_camera": ...}]}``; of a pose without a frame nothing was seen (yet): what is known is told for it.

* ``Placed``: one pose, ``Placed("f1.png", world_from_camera)``

Camera moves as a file: where a camera may go, or shall go.

``{"format": "moves/1", "moves": [{"name": "left", "T_present_candidate": [[...], ...]}, {"T_world_camera": [[...],
...]}]}``: a pose in the present camera's frame or in the world, 4x4, metres. A ``poses/1`` file (``frames`` with
``T_world_camera``) is read as well.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Floats, frozen
from geometry.errors import CameraError, GeometryError, told
from geometry.files.plain_files import json_of, must_be_plain, parsed_json, text_of
from geometry.frames import from_rotation_translation, inverse, is_rigid, rotation_from_quat_xyzw

MOVES = "moves/1"
WORLD, PRESENT = "T_world_camera", "T_present_candidate"
LARGEST = 16 * 2**20
"""Largest file of poses or moves that is read, bytes."""
ROUNDED = 1e-3
"""How far a matrix may be from a rotation by the rounding of what wrote it; the nearest rotation is taken."""
EXACT = 1e-12
"""How far it may be and is left as it is."""
HOLDS = 'should be {"format": "poses/1", "frames": [{"frame": FILE or null, "T_world_camera": 4x4}, ...]}'


class Placed(NamedTuple):
    """``frame``: the name of the image or Γ that was taken there, None for none.

    ``world_from_camera`` (4, 4), metres.
    """

    frame: str | None
    world_from_camera: Floats


def read_poses(path: Path | str) -> list[Placed]:
    """The poses of a file, in its order: JSON where it begins with a brace, else lines.

    Raises CameraError, a line a mistake.
    """
    must_be_plain(path, CameraError, LARGEST)
    text = text_of(path, LARGEST, CameraError)
    poses = _of_json(text, path) if text.lstrip().startswith(("{", "[")) else _of_lines(text, path)
    if not poses:
        raise CameraError(f"{path}: holds no pose: {HOLDS}, or lines 'name tx ty tz qx qy qz qw'")
    return poses


def _of_json(text: str, path: Path | str) -> list[Placed]:
    document = parsed_json(text, str(path), HOLDS, CameraError)
    frames = document.get("frames") if isinstance(document, dict) and document.get("format") == "poses/1" else None
    if not isinstance(frames, list):
        raise CameraError(f"{path}: {HOLDS}")
    return _sound([_entry(f"{path}: frames.{i}", frame) for i, frame in enumerate(frames)])


def _entry(where: str, frame: Any) -> Placed | str:  # noqa: ANN401 - parsed JSON
    if not isinstance(frame, dict) or not set(frame) <= {"frame", "T_world_camera"} or "T_world_camera" not in frame:
        return f"{where}: must have the keys frame and T_world_camera, and no other"
    name = frame.get("frame")
    if name is not None and not isinstance(name, str):
        return f"{where}.frame: must be a file's name or null, not {name!r:.60}"
    nearest = nearest_rigid(frame["T_world_camera"])
    return (
        f"{where}.T_world_camera: must be a rigid 4x4 matrix (row-major, metres)"
        if nearest is None
        else Placed(name, nearest)
    )


def nearest_rigid(value: object) -> Floats | None:
    """The rigid pose (4, 4) that rows of numbers are but for rounding; None where they are none."""
    try:
        pose = np.array(value, np.float64)
    except (TypeError, ValueError):
        return None
    if pose.shape != (4, 4) or not np.isfinite(pose).all() or not is_rigid(pose, ROUNDED):
        return None
    if is_rigid(pose, EXACT):
        return frozen(pose)
    u, _, v = np.linalg.svd(pose[:3, :3])
    return frozen(from_rotation_translation(u @ v, pose[:3, 3]))


def _of_lines(text: str, path: Path | str) -> list[Placed]:
    lines = [(i, line.split("#")[0].split()) for i, line in enumerate(text.splitlines(), 1)]
    return _sound([_line(f"{path}:{i}", words) for i, words in lines if words])


def _line(where: str, words: list[str]) -> Placed | str:
    rule = f"{where}: must be 'name tx ty tz qx qy qz qw', eight words, the quaternion of length 1"
    try:
        numbers = np.array([float(word) for word in words[1:]])
    except ValueError:
        return rule
    if len(numbers) != 7 or not np.isfinite(numbers).all() or abs(np.linalg.norm(numbers[3:]) - 1.0) > ROUNDED:
        return rule
    quat_xyzw = numbers[3:] / np.linalg.norm(numbers[3:])
    return Placed(words[0], frozen(from_rotation_translation(rotation_from_quat_xyzw(quat_xyzw), numbers[:3])))


def _sound(entries: list[Placed | str]) -> list[Placed]:
    """The poses. Raises CameraError with all mistakes."""
    mistakes = [entry for entry in entries if isinstance(entry, str)]
    if mistakes:
        raise CameraError(told(mistakes))
    return [entry for entry in entries if not isinstance(entry, str)]


class Move(NamedTuple):
    """One place: in the present camera's frame or in the world, (4, 4), m."""

    name: str
    present_from_candidate: Floats | None
    world_from_camera: Floats | None

    def present(self, world_from_present: Floats | None) -> Floats:
        """present_from_candidate (4, 4).

        Raises GeometryError where it is told in the world, and the present place there is not known.
        """
        if self.present_from_candidate is not None:
            return self.present_from_candidate
        if self.world_from_camera is None or world_from_present is None:
            raise GeometryError(
                f"{self.name}: is told in the world ({WORLD}), but where the present camera is there is not known: give {PRESENT}"
            )
        return np.asarray(inverse(world_from_present) @ self.world_from_camera)

    def world(self, world_from_present: Floats) -> Floats:
        """world_from_camera (4, 4)."""
        return self.world_from_camera if self.world_from_camera is not None else world_from_present @ self.present(None)


def read_moves(path: Path) -> list[Move]:
    """The moves of a file, in its order. Raises GeometryError that names the file, the key and what would be right."""
    document = json_of(path, LARGEST, "it should hold moves", GeometryError)
    kind = document.get("format") if isinstance(document, dict) else None
    if kind == "poses/1":
        return [Move(p.frame or f"move {i}", None, p.world_from_camera) for i, p in enumerate(read_poses(path), 1)]
    if kind != MOVES:
        raise GeometryError(f"{path}: format: {kind!r:.40} should be {MOVES!r} or 'poses/1'")
    rows = document.get("moves")
    if not isinstance(rows, list) or not rows:
        raise GeometryError(f"{path}: moves: should be a list of at least one pose")
    return [_move(row, f"{path}: moves.{i}", i) for i, row in enumerate(rows)]


def _move(row: Any, place: str, number: int) -> Move:  # noqa: ANN401 - parsed JSON
    keys = [key for key in (PRESENT, WORLD) if isinstance(row, dict) and row.get(key) is not None]
    if len(keys) != 1:
        raise GeometryError(f"{place}: should be an object with one of {PRESENT} and {WORLD}")
    rigid = nearest_rigid(row[keys[0]])
    if rigid is None:
        raise GeometryError(f"{place}.{keys[0]}: must be a rigid 4x4 matrix (row-major, metres)")
    name = str(row.get("name", f"move {number + 1}"))
    return Move(name, rigid, None) if keys[0] == PRESENT else Move(name, None, rigid)
