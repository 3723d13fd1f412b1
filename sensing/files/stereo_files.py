"""How a stereo pair is calibrated, as a file: ``stereo/1``.

``{"format": "stereo/1", "T_right_left": 4x4, "left": {camera}, "right": {camera}}``: ``T_right_left`` maps points of
the left camera's frame to the right one's, metres; the cameras are needed for images, and left out where both inputs
are Γ files, which have their own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geometry.camera import Camera, camera_from_dict
from geometry.errors import CameraError
from geometry.files.json_files import JsonError, json_of
from geometry.files.plain_files import fault_of
from geometry.files.pose_files import nearest_rigid
from sensing.files.stereo import Pair

LARGEST = 2**20
"""Bytes of such a file that are read."""
HOLDS = 'should be {"format": "stereo/1", "T_right_left": 4x4, "left": {camera}, "right": {camera}}'


class Calibration(NamedTuple):
    """The pair, and its cameras where the file has them."""

    pair: Pair
    left: Camera | None
    right: Camera | None


def read_stereo(path: Path | str) -> Calibration:
    """The calibration of a file. Raises CameraError, one line."""
    fault = fault_of(Path(path), LARGEST)
    if fault is not None:
        raise CameraError(f"{path}: {fault}")
    try:
        document = json_of(Path(path), LARGEST, HOLDS)
    except JsonError as error:
        raise CameraError(str(error)) from None
    if not isinstance(document, dict) or document.get("format") != "stereo/1" or "T_right_left" not in document:
        raise CameraError(f"{path}: {HOLDS}")
    unknown = sorted(set(document) - {"format", "T_right_left", "left", "right"})
    if unknown:
        raise CameraError(f"{path}: {unknown[0]}: unknown key; it {HOLDS}")
    return Calibration(
        _pair(path, document["T_right_left"]), *(_camera(path, document, side) for side in ("left", "right"))
    )


def _pair(path: Path | str, value: Any) -> Pair:  # noqa: ANN401 - parsed JSON
    try:
        pose = nearest_rigid(np.array(value, np.float64))
    except (TypeError, ValueError):
        pose = None
    if pose is None:
        raise CameraError(f"{path}: T_right_left: must be a rigid 4x4 matrix (row-major, metres)")
    try:
        return Pair(pose)
    except CameraError as error:
        raise CameraError(f"{path}: {error}") from None


def _camera(path: Path | str, document: dict[str, Any], side: str) -> Camera | None:
    if side not in document:
        return None
    try:
        return camera_from_dict(document[side], side)
    except CameraError as error:
        raise CameraError(f"{path}: {error}") from None
