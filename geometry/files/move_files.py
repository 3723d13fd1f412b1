"""Camera moves as a file: where a camera may go, or shall go.

``{"format": "moves/1", "moves": [{"name": "left", "T_present_candidate": [[...], ...]}, {"T_world_camera": [[...],
...]}]}``: a pose in the present camera's frame or in the world, 4x4, metres. A ``poses/1`` file (``frames`` with
``T_world_camera``) is read as well.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from geometry.errors import GeometryError
from geometry.files.json_files import JsonError, json_of
from geometry.files.pose_files import nearest_rigid, read_poses
from geometry.frames import inverse

if TYPE_CHECKING:
    from pathlib import Path

    from geometry.arrays import Floats

MOVES = "moves/1"
LARGEST = 16 * 2**20
"""Bytes of a file of moves."""
WORLD, PRESENT = "T_world_camera", "T_present_candidate"


class Move(NamedTuple):
    """One place: in the present camera's frame or in the world, (4, 4), m."""

    name: str
    present_from_candidate: Floats | None
    world_from_camera: Floats | None

    def present(self, world_from_present: Floats | None) -> Floats:
        """present_from_candidate (4, 4). Raises GeometryError where it is told in the world, and the present place there is not known."""
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
    try:
        document = json_of(path, LARGEST, "it should hold moves")
    except JsonError as error:
        raise GeometryError(str(error)) from None
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
    try:
        pose = np.array(row[keys[0]], dtype=float)
    except (TypeError, ValueError):
        pose = np.zeros(0)
    rigid = nearest_rigid(pose)
    if rigid is None:
        raise GeometryError(f"{place}.{keys[0]}: must be a rigid 4x4 matrix (row-major, metres)")
    name = str(row.get("name", f"move {number + 1}"))
    return Move(name, rigid, None) if keys[0] == PRESENT else Move(name, None, rigid)
