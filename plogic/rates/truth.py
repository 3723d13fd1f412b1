"""``truth.json``: what stands where in a scene, known from outside of perception (``plogic simulate`` writes it)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

FORMAT = "truth/1"
LARGEST = 16 * 2**20
"""Bytes of a truth file."""


@dataclass(frozen=True)
class TrueObject:
    """One object: its type (None for what no knowledge base knows), its pose, and the visible share of its picture."""

    label: str | None
    camera_from_object: NDArray[np.float64]
    visible_fraction: float


@dataclass(frozen=True)
class Truth:
    """``complete``: whether every object of known type is listed; else those that are not may be there."""

    objects: tuple[TrueObject, ...]
    complete: bool


def read_truth(path: Path) -> Truth:
    """Read a truth file; raises InputError that names the file, the key and what would be right."""
    try:
        if path.stat().st_size > LARGEST:
            raise InputError(f"{path}: is larger than the {LARGEST} bytes that a truth file may have")
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: is no JSON: {error}") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f"{path}: format: should be {FORMAT!r}")
    complete, objects = data.get("complete", True), data.get("objects")
    if not isinstance(complete, bool):
        raise InputError(f"{path}: complete: {complete!r:.40} should be true or false")
    if not isinstance(objects, list):
        raise InputError(f"{path}: objects: should be a list")
    return Truth(tuple(_object(path, i, entry) for i, entry in enumerate(objects)), complete)


def _object(path: Path, index: int, entry: Any) -> TrueObject:  # noqa: ANN401 - parsed JSON
    place = f"{path}: objects.{index}"
    if not isinstance(entry, dict):
        raise InputError(f"{place}: should be an object with label and T_camera_object")
    label, fraction = entry.get("label"), entry.get("visible_fraction", 1.0)
    if label is not None and not isinstance(label, str):
        raise InputError(f"{place}.label: {label!r:.40} should be a type's name, or null")
    if isinstance(fraction, bool) or not isinstance(fraction, int | float) or not 0.0 <= fraction <= 1.0:
        raise InputError(f"{place}.visible_fraction: {fraction!r:.40} should be a number from 0 to 1")
    return TrueObject(label, _pose(f"{place}.T_camera_object", entry.get("T_camera_object")), float(fraction))


def _pose(place: str, value: object) -> NDArray[np.float64]:
    try:
        pose = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        pose = np.zeros(0)
    rigid = (
        pose.shape == (4, 4)
        and np.isfinite(pose).all()
        and np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-4)
    )
    if not rigid or not np.allclose(pose[3], (0.0, 0.0, 0.0, 1.0)):
        raise InputError(f"{place}: should be a rigid motion, 4 rows of 4 numbers, metres")
    return pose
