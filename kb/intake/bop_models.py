"""A BOP ``models`` folder: ``obj_000001.ply`` and so on in millimetres, and ``models_info.json`` with their symmetries.

The format: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md
"""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Floats, numbers_of
from geometry.files.documents import read_json
from geometry.files.plain_files import is_there, must_be_plain
from geometry.frames import quat_xyzw_from_rotation
from kb.errors import IntakeError
from kb.files.quantities import LARGEST, LENGTHS
from kb.files.schema import SymmetryModel
from kb.files.write import flow
from kb.surfaces.symmetries import motions

RIGID = 1e-2
"""How far a listed rotation may be from one."""
MAX_BYTES = 16_000_000
"""Largest models_info.json."""
MEANT, MOST_FOLD = 0.005, 12
"""Share of a circle by which a published turn may be off the one that it means, of so many folds at most."""
_MODEL = re.compile(r"obj_(\d+)\.ply")


def bop_models(folder: Path) -> list[tuple[str, Path, dict[str, Any]]]:
    """(name, mesh file, its entry of ``models_info.json``) of every model, in the order of their numbers.

    Its name there, where all have one, and each its own; else ``obj_000001`` and so on.

    Raises:
        IntakeError: no such folder, no models, a ``models_info.json`` that is none.
    """
    files = sorted((path for path in folder.iterdir() if _MODEL.fullmatch(path.name)), key=_number)
    if not files:
        raise IntakeError(f"{folder}: holds no obj_000001.ply and so on, as a BOP models folder does")
    info = _info(folder / "models_info.json")
    rows = [info.get(str(_number(path)), {}) for path in files]
    names = [row.get("name") for row in rows]
    if not all(_is_folder(name) for name in names) or len(set(names)) < len(names):
        names = [path.stem for path in files]
    return list(zip(names, files, rows, strict=True))


def _is_folder(name: object) -> bool:
    """Whether a name can be that of a type's folder."""
    return isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}", name) is not None


def _number(path: Path) -> int:
    found = _MODEL.fullmatch(path.name)
    return int(found[1]) if found else 0


def _info(path: Path) -> dict[str, Any]:
    if not is_there(path):
        return {}
    must_be_plain(path, IntakeError, MAX_BYTES)
    holds = "models' numbers, their properties, and lists of numbers are all it may hold"
    info = read_json(path, MAX_BYTES, holds, IntakeError).data
    if not isinstance(info, dict) or not all(isinstance(row, dict) for row in info.values()):
        raise IntakeError(f"{path}: must map the models' numbers to their properties")
    return info


def bop_symmetries(entry: dict[str, Any], units: str, where: str) -> list[str]:
    """Entries of object.yaml's ``symmetries`` for a model's ``symmetries_discrete`` and ``symmetries_continuous``.

    Raises:
        IntakeError: for anything that is no rigid motion, or no axis, and for motions that make no small group.
    """
    scale = LENGTHS[units]
    axes = [
        _axis(row, scale, f"{where}: symmetries_continuous") for row in _rows(entry, "symmetries_continuous", where)
    ]
    listed = [(row, f"{where}: symmetries_discrete") for row in _rows(entry, "symmetries_discrete", where)]
    found = [_motion(row, scale, place) for row, place in listed] + axes
    try:
        motions([SymmetryModel.model_validate(row) for row in found])
    except ValueError:
        found = [_turn(row, scale, place) for row, place in listed] + axes
        try:
            motions([SymmetryModel.model_validate(row) for row in found])
        except ValueError as error:
            raise IntakeError(f"{where}: its symmetries cannot be used: {error}") from None
    return [flow(row) for row in found]


def _rows(entry: dict[str, Any], key: str, where: str) -> list[Any]:
    rows = entry.get(key, [])
    if not isinstance(rows, list):
        raise IntakeError(f"{where}: {key} must be a list")
    return rows


def _motion(row: object, scale: float, where: str) -> dict[str, Any]:
    """One motion, sixteen numbers by rows, its rotation made exact."""
    turn, shift = _rigid(row, where)
    return {"quat_xyzw": _rounded(np.asarray(quat_xyzw_from_rotation(turn))), "at": _rounded(shift * scale)}


def _rigid(row: object, where: str) -> tuple[Floats, Floats]:
    """The nearest rotation (3, 3) to that of sixteen numbers by rows, and the shift (3,)."""
    motion = _numbers(row, 16, where).reshape(4, 4)
    turn = motion[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > RIGID or np.linalg.det(turn) < 0:
        raise IntakeError(f"{where}: must be a rigid motion, not {row!r:.100}")
    u, _, v = np.linalg.svd(turn)
    return u @ v, motion[:3, 3]


def _turn(row: object, scale: float, where: str) -> dict[str, Any]:
    """The turn about an axis that a published motion means, which was fitted to a scan and closes no group.

    Raises:
        IntakeError: it is no turn by a whole part of a circle, within ``MEANT``.
    """
    turn, shift = _rigid(row, where)
    quat = np.asarray(quat_xyzw_from_rotation(turn))
    angle = 2.0 * math.atan2(float(np.linalg.norm(quat[:3])), float(quat[3]))
    fold = next(
        (n for n in range(2, MOST_FOLD + 1) if abs(angle * n / (2.0 * math.pi) % 1.0 - 0.5) > 0.5 - n * MEANT), 0
    )
    if not fold or not np.linalg.norm(quat[:3]) > MEANT:
        raise IntakeError(f"{where}: is no turn by a whole part of a circle: {math.degrees(angle):.1f} degrees")
    axis = np.asarray(quat[:3] / np.linalg.norm(quat[:3]), float)
    fixed = np.linalg.lstsq(np.eye(3) - turn, shift - (shift @ axis) * axis, rcond=1e-6)[0]
    return {"axis": _rounded(axis), "fold": fold, "at": _rounded(fixed * scale)}


def _axis(row: object, scale: float, where: str) -> dict[str, Any]:
    if not isinstance(row, dict):
        raise IntakeError(f"{where}: must be an axis with an offset, not {row!r:.100}")
    axis, offset = _numbers(row.get("axis"), 3, where), _numbers(row.get("offset", [0, 0, 0]), 3, where)
    size = math.hypot(*axis)
    if not size > 0:
        raise IntakeError(f"{where}: an axis must have a direction, not {row!r:.100}")
    return {"axis": _rounded(axis / size), "continuous": True, "at": _rounded(offset * scale)}


def _numbers(value: object, count: int, where: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    found = numbers_of(value, count, LARGEST)
    if found is None:
        raise IntakeError(f"{where}: must be {count} finite numbers below {LARGEST:g}, not {value!r:.100}")
    return found


def _rounded(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    return [float(f"{value + 0.0:.9g}") for value in values]
