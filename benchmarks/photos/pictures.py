"""The picture of one photo's answers beside its truth: both outlines over the photo, and how far apart they are.

The truth's outline is dashed, white; what was accepted is green where it is right, orange where it is found, red where
it is neither. Each name stands with ADD in diameters and the outlines' overlap.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from geometry.visibility.outline import outline
from plogic.base.errors import InputError
from plogic.face.shown.overlay import LARGE
from plogic.face.shown.pencil import WHITE, Box, Colour, Pencil, beside

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from benchmarks.photos.answers import Shown
    from benchmarks.photos.score import Posed, Told
    from geometry.arrays import Bytes, Floats
    from geometry.camera import Camera
    from geometry.visibility.rays import RayMesh

GREEN, ORANGE, RED = (115, 158, 0), (0, 159, 230), (0, 94, 213)
"""Blue, green, red; of Okabe and Ito's palette, which colour-blind eyes tell apart."""
TEXT = 0.6
LEGEND = "dashed: the truth; green: right; orange: found; red: neither"


def folder_made(path: Path) -> Path:
    """The folder of pictures, made where it is not there. Raises InputError where it cannot be."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made: {error.strerror}") from None
    return path


def drawn(
    shown: Shown,
    answers: Sequence[Posed],
    rows: Sequence[Told],
    surfaces: Mapping[int, RayMesh],
    names: Mapping[int, str],
) -> Bytes:
    """The photo (H, W, 3) with the outlines, doubled where it is small.

    ``rows``: of each truth what stands for it.
    """
    camera = shown.camera
    scale = 1 if camera.width >= LARGE else 2
    picture = np.asarray(cv2.resize(shown.image, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC), np.uint8)
    pencil = Pencil(picture, scale)
    labels: list[tuple[str, Colour, list[Floats]]] = []
    for answer in answers:
        text, colour = _verdict(
            next((row for row in rows if row.answer is answer), None), there=answer.obj_id in shown.neither
        )
        rings = _rings(answer, surfaces[answer.obj_id], camera)
        labels.append((f"{names[answer.obj_id]}: {text}", colour, rings))
        for ring in rings:
            pencil.stroke(ring.tolist(), colour, 2, dashed=False)
    for truth, row in zip(shown.truths, rows, strict=True):  # on top: what is right is seen between its dashes
        rings = _rings(truth, surfaces[truth.obj_id], camera)
        if row.answer is None:
            labels.append((f"{names[truth.obj_id]}: missed", WHITE, rings))
        for ring in rings:
            pencil.stroke(ring.tolist(), WHITE, 2, dashed=True)
    _write(pencil, labels)
    return picture


def _verdict(row: Told | None, *, there: bool) -> tuple[str, Colour]:
    if row is None or row.error is None or row.overlap is None:
        return ("there, its pose is not known", WHITE) if there else ("not there", RED)
    colour = GREEN if row.right else ORANGE if row.found else RED
    return f"ADD {row.error:.3f}, overlap {row.overlap:.2f}", colour


def _rings(posed: Posed, surface: RayMesh, camera: Camera) -> list[Floats]:
    """The closed rings (N, 2) of its outline, pixels."""
    area = outline(surface.vertices, surface.triangles, posed.camera_from_object, camera)
    return [np.array(part.exterior.coords) for part in getattr(area, "geoms", [area]) if not part.is_empty]


def _write(pencil: Pencil, labels: Sequence[tuple[str, Colour, list[Floats]]]) -> None:
    """Each text beside its object, clear of the others, where it covers little of any object."""
    height, width = pencil.picture.shape[:2]
    mask = np.zeros((height, width), np.uint8)
    for _, _, rings in labels:
        for ring in rings:
            cv2.fillPoly(mask, [np.rint([pencil.at(p) for p in ring]).astype(np.int32)], 1)
    cover = np.asarray(cv2.integral(mask), np.float64)
    wide, high = pencil.size(LEGEND, TEXT)
    taken: list[Box] = [(8.0, height - 10.0 - high, 8.0 + wide, height - 10.0)]
    pencil.text(LEGEND, taken[0], TEXT, WHITE)
    for text, colour, rings in labels:
        if rings:
            places = np.array([pencil.at(p) for ring in rings for p in ring])
            (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
            box = beside(pencil.size(text, TEXT), (left, top, right, bottom), taken, cover)
            if box is not None:
                taken.append(box)
                pencil.text(text, box, TEXT, colour)
