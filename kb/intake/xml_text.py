"""XML of robot descriptions, read without what makes XML dangerous, and the few things that URDF and SDF share."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np

from geometry.files.plain_files import fault_of
from geometry.frames import from_rotation_translation
from kb.errors import IntakeError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    Frame = NDArray[np.float64]

MAX_BYTES = 20_000_000
"""Largest description."""
MAX_DEPTH = 60
"""Deepest nesting."""
LARGEST = 1e9
"""What every number stays below: sizes in m, angles, scales."""
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")


def read_xml(path: Path) -> ET.Element:
    """The root element; what the declaration says is not asked, as pybullet's own files have version 0.0 there.

    Raises:
        IntakeError: no file, too large, no XML, nested too deeply, or one that defines entities.
    """
    fault = fault_of(path, MAX_BYTES)
    if fault is not None:
        raise IntakeError(f"{path}: {fault}")
    try:
        text = path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise IntakeError(f"{path}: cannot be read: {error.strerror}") from None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise IntakeError(f"{path}: defines entities, which no robot description needs")
    try:
        root = ET.fromstring(_DECLARATION.sub("", text))  # noqa: S314 - no entities: see above
    except ET.ParseError as error:
        raise IntakeError(f"{path}: is no XML: {error}") from None
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
        if depth > MAX_DEPTH:
            raise IntakeError(
                f"{path}: its elements are nested deeper than {MAX_DEPTH} levels, which no robot description needs"
            )
    return root


def numbers(text: str | None, count: int, default: float, what: str) -> list[float]:
    """``count`` numbers of a text, all ``default`` where there is none; raises IntakeError for anything else."""
    if text is None or not text.strip():
        return [default] * count
    try:
        found = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        found = []
    if len(found) != count or not all(abs(number) < LARGEST for number in found):
        raise IntakeError(
            f"{what}: must be {count} finite number{'s'[: count > 1]} below {LARGEST:g}, not {text.strip()!r:.60}"
        )
    return found


def frame(xyz: list[float], rpy: list[float]) -> Frame:
    """parent_from_child (4, 4): turns about the parent's x, y, z by roll, pitch, yaw (rad), then the shift ``xyz`` (m)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    turn = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.asarray(from_rotation_translation(np.array(turn), np.array(xyz)))


def found_file(folder: Path, name: str) -> Path | None:
    """The file that a description names: relative to its ``folder``, or, as ``package://NAME/REST`` and ``model://``, beneath a folder above."""
    rest = re.sub(r"^(file|package|model)://", "", name.strip())
    plain = "://" not in name or name.startswith("file:")
    for place in _places(folder, rest, plain=plain):
        if fault_of(place) is None:
            return place
    return None


def _places(folder: Path, rest: str, *, plain: bool) -> Iterator[Path]:
    yield folder / rest
    if plain:
        return
    inside = rest.partition("/")[2]
    for above in [folder, *folder.resolve().parents][:6]:
        yield above / rest
        yield above / inside
