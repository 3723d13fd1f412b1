"""What a camera description must satisfy; every mistake is named by its key, all of them at once."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from geometry.distortion import LENGTHS
from geometry.frames import is_rigid

KEYS = ("width", "height", "K", "dist", "T_world_camera")
MAX_SIDE = 65536  # px
SHORTEST, LARGEST = (
    1e-3,
    1e9,
)  # px; focal lengths beyond, and larger numbers of a matrix, belong to no camera, and squares of them overflow
STRONGEST = 1e6  # a distortion coefficient; past a few thousand no lens is known


def camera_mistakes(document: object, where: str = "camera") -> list[str]:
    """Each mistake in the contract's `camera` key as one line `where.key: rule, value`; empty for a good camera."""
    if not isinstance(document, Mapping):
        return [f"{where}: must be an object with the keys width, height and K, not {_shown(document)}"]
    unknown = [f"{where}.{key}: unknown key; known are {', '.join(KEYS)}" for key in document if key not in KEYS]
    missing = [f"{where}.{key}: is missing" for key in KEYS[:3] if key not in document]
    sides = [_side(document[key], f"{where}.{key}") for key in KEYS[:2] if key in document]
    rest = [_matrix(document[key], f"{where}.K") for key in ("K",) if key in document]
    rest += [_dist(document.get("dist", []), f"{where}.dist")]
    rest += [_pose(document.get("T_world_camera"), f"{where}.T_world_camera")]
    return unknown + missing + [mistake for mistake in sides + rest if mistake]


def _side(value: object, where: str) -> str:
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if whole and 1 <= int(str(value)) <= MAX_SIDE:
        return ""
    return f"{where}: must be a whole number of pixels from 1 to {MAX_SIDE}, not {_shown(value)}"


def _matrix(value: object, where: str) -> str:
    K = _numbers(value)
    if K is None or K.shape != (3, 3):
        return f"{where}: must be a 3x3 matrix of finite numbers, not {_shown(value)}"
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        return f"{where}: focal lengths must be positive, not {K[0, 0]:g} and {K[1, 1]:g}"
    if min(K[0, 0], K[1, 1]) < SHORTEST or np.abs(K).max() > LARGEST:
        return f"{where}: focal lengths must be at least {SHORTEST:g} px, and no number above {LARGEST:g}, not {_shown(value)}"
    if K[1, 0] != 0 or K[2].tolist() != [0, 0, 1]:
        return f"{where}: must be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]], not {_shown(value)}"
    return ""


def _dist(value: object, where: str) -> str:
    dist = _numbers(value)
    if dist is None or dist.ndim != 1 or len(dist) not in LENGTHS:
        return f"{where}: must be a list of {', '.join(map(str, LENGTHS))} finite numbers, not {_shown(value)}"
    if np.abs(dist).max(initial=0.0) > STRONGEST:
        return f"{where}: no coefficient may be above {STRONGEST:g}, not {_shown(value)}"
    return ""


def _pose(value: object, where: str) -> str:
    if value is None:
        return ""
    pose = _numbers(value)
    if pose is None or not is_rigid(pose):
        return f"{where}: must be a rigid 4x4 matrix (row-major, metres), not {_shown(value)}"
    if np.abs(pose).max() > LARGEST:
        return f"{where}: no number may be above {LARGEST:g} m, not {_shown(value)}"
    return ""


def _numbers(value: object) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """`value` as an array of finite numbers; None for anything else (texts and truth values are no numbers)."""
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        return None
    if array.size == 0:
        return array.astype(np.float64) if isinstance(value, (list, tuple, np.ndarray)) else None
    if array.dtype.kind not in "iuf":
        return None
    numbers = array.astype(np.float64)
    return numbers if np.isfinite(numbers).all() else None


def _shown(value: object) -> str:
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value).replace("\n", " ")
    return text if len(text) <= 80 else text[:77] + "..."
