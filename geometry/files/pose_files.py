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
from typing import Annotated, Literal, NamedTuple, NotRequired, TypedDict, cast

import numpy as np

from geometry.arrays import Floats, frozen
from geometry.camera_row import RIGID, Pose
from geometry.errors import CameraError, GeometryError, Mistake, told
from geometry.files.documents import Document, parsed_json, read_json
from geometry.files.plain_files import must_be_plain, text_of
from geometry.frames import from_rotation_translation, inverse, is_rigid, rotation_from_quat_xyzw
from geometry.json_shapes import Size

MOST = 1_000_000
"""Poses or moves of a file."""
WORLD, PRESENT = "T_world_camera", "T_present_candidate"
LARGEST = 16 * 2**20
"""Largest file of poses or moves that is read, bytes."""
ROUNDED = 1e-3
"""How far a matrix may be from a rotation by the rounding of what wrote it; the nearest rotation is taken."""
EXACT = 1e-12
"""How far it may be and is left as it is."""
HOLDS = 'should be {"format": "poses/1", "frames": [{"frame": FILE or null, "T_world_camera": 4x4}, ...]}'


class FrameRow(TypedDict):
    """Where the camera stood for one frame."""

    frame: NotRequired[
        Annotated[
            str | None, "Name of the image or Γ that was taken there; null, or left out: nothing was seen there yet."
        ]
    ]
    T_world_camera: Annotated[Pose, "Maps camera coordinates to the world's (z up); row-major, metres."]


class PosesRow(TypedDict):
    """Where a moving camera stood, frame by frame."""

    format: Literal["poses/1"]
    frames: Annotated[list[FrameRow], Size(1, MOST), "The poses, in the order of the frames."]


class MoveRow(TypedDict):
    """One place, in the present camera's frame or in the world: one of the two poses."""

    name: NotRequired[Annotated[str, "What it is called in answers."]]
    T_present_candidate: NotRequired[
        Annotated[Pose | None, "Maps coordinates of the camera there to those of the present one; row-major, metres."]
    ]
    T_world_camera: NotRequired[
        Annotated[Pose | None, "Maps coordinates of the camera there to the world's; row-major, metres."]
    ]


class MovesRow(TypedDict):
    """Where a camera may go, or shall go."""

    format: Literal["moves/1"]
    moves: Annotated[list[MoveRow], Size(1, MOST), "The places."]


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
    return _posed(parsed_json(text, str(path), HOLDS, CameraError, single=True))


def _posed(document: Document) -> list[Placed]:
    """The poses of a `PosesRow`. Raises CameraError with every mistake."""
    wrong = document.against(PosesRow)
    frames = [] if wrong else cast("PosesRow", document.data)["frames"]
    poses = [nearest_rigid(frame["T_world_camera"]) for frame in frames]
    wrong += [Mistake(("frames", i, WORLD), RIGID) for i, pose in enumerate(poses) if pose is None]
    if wrong:
        raise CameraError(told(document.told(wrong)))
    return [Placed(frame.get("frame"), pose) for frame, pose in zip(frames, poses, strict=True) if pose is not None]


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
    """The moves of a file, in its order, a ``poses/1`` file's as well.

    Raises GeometryError, a line a mistake.
    """
    document = read_json(path, LARGEST, "it should hold moves", GeometryError, single=True)
    kind = document.data.get("format") if isinstance(document.data, dict) else None
    if kind == "poses/1":
        return [Move(p.frame or f"move {i}", None, p.world_from_camera) for i, p in enumerate(_posed(document), 1)]
    wrong = document.against(MovesRow)
    rows = [] if wrong else cast("MovesRow", document.data)["moves"]
    moves = [_move(row, i) for i, row in enumerate(rows)]
    wrong += [each for each in moves if isinstance(each, Mistake)]
    if wrong:
        raise GeometryError(told(document.told(wrong)))
    return [each for each in moves if isinstance(each, Move)]


def _move(row: MoveRow, number: int) -> Move | Mistake:
    present, world = row.get("T_present_candidate"), row.get("T_world_camera")
    given = world if present is None else present
    if given is None or (present is not None and world is not None):
        return Mistake(("moves", number), f"should be an object with one of {PRESENT} and {WORLD}")
    rigid = nearest_rigid(given)
    if rigid is None:
        return Mistake(("moves", number, WORLD if present is None else PRESENT), RIGID)
    name = row.get("name", f"move {number + 1}")
    return Move(name, None, rigid) if present is None else Move(name, rigid, None)
