"""The picture of one scene: its plane as a faint grid, how each thing is held in truth, and what was accepted.

Outlines are those of ``benchmarks.photos.pictures``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from benchmarks.photos.pictures import drawn
from benchmarks.support.score import feet
from geometry.bodies.resting import along_plane
from plogic.face.shown.overlay import LARGE
from plogic.face.shown.pencil import WHITE, Pencil
from sensing.files.whole_files import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from benchmarks.photos.score import Posed
    from benchmarks.photos.table import Measure
    from benchmarks.support.scenes import Stood
    from geometry.arrays import Bytes, Floats

STEP, STEPS = 0.05, 12
"""Metres between neighbouring lines of the grid, and how many there are on each side of its middle."""
FAINT = 0.3
SAMPLES = 60
"""Places of a line: what is behind the camera is left out."""
TEXT = 0.5


def draw(stood: Stood, answers: Sequence[Posed], measure: Measure, folder: Path) -> None:
    """The picture of a scene. Raises SensingError where it cannot be written."""
    rows = measure.counted(stood.shown, answers)[1]
    shown = stood.shown._replace(image=with_grid(stood))
    picture = drawn(shown, answers, rows, measure.surfaces, measure.names)
    _write(picture, stood, measure)
    write_whole(folder / f"support_{shown.name}.png", bytes(cv2.imencode(".png", picture)[1].tobytes()))


def with_grid(stood: Stood) -> Bytes:
    """The photo (H, W, 3) with the plane of what stands there as a faint grid."""
    lines = stood.shown.image.copy()
    for line in grid(stood):
        cv2.polylines(lines, [np.rint(line * 16).astype(np.int32)], False, WHITE, 1, cv2.LINE_AA, shift=4)  # noqa: FBT003 - OpenCV's
    return np.asarray(cv2.addWeighted(lines, FAINT, stood.shown.image, 1.0 - FAINT, 0.0), np.uint8)


def grid(stood: Stood) -> list[Floats]:
    """Lines (N, 2) of the plane around what stands there, pixels."""
    middle, axes = feet(stood), along_plane(stood.plane.up)
    reach = STEP * STEPS
    along = np.linspace(-reach, reach, SAMPLES)
    lines = []
    for one, other in ((axes[:, 0], axes[:, 1]), (axes[:, 1], axes[:, 0])):
        for aside in np.linspace(-reach, reach, 2 * STEPS + 1):
            uv = stood.shown.camera.project(middle + aside * other + along[:, None] * one)
            lines.append(uv[np.isfinite(uv).all(axis=1) & (np.abs(uv) < 1e4).all(axis=1)])
    return lines


def _write(picture: Bytes, stood: Stood, measure: Measure) -> None:
    """How each thing is held, at its middle."""
    shown = stood.shown
    pencil = Pencil(picture, 1 if shown.camera.width >= LARGE else 2)
    for truth, stance in zip(shown.truths, stood.stances, strict=True):
        lower = None if stance.on is None else measure.names[shown.truths[stance.on].obj_id]
        text = stance.kind if lower is None else f"on {lower}"
        places = measure.surfaces[truth.obj_id].vertices @ truth.camera_from_object[:3, :3].T
        middle = pencil.at(shown.camera.project(places.mean(axis=0)[None] + truth.camera_from_object[:3, 3])[0])
        wide, high = pencil.size(text, TEXT)
        left, top = middle[0] - wide / 2.0, middle[1] - high / 2.0
        pencil.text(text, (left, top, left + wide, top + high), TEXT, WHITE)
