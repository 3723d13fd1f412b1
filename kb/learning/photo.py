"""A photo laid onto the mesh that it shows: the triangles it shows are painted with it, the others plain grey.

* ``registered``: camera and pose of the photo from clicked points, or every mistake of theirs
* ``painted``: a ``PaintedMesh``, which is rendered and learned from like any textured mesh
* ``on_shown``: what was observed on the triangles that the photo shows, away from grey ones

``Points``: clicked correspondences, pixels of a photo and the places of the object that they show, from a small text:
YAML or JSON, a mapping with ``units`` (m where it is missing) and ``points``, each ``[u, v, x, y, z]`` or ``{pixel: [u,
v], at: [x, y, z]}``; or CSV, five numbers a line in the unit that is handed in, with or without the header
``u,v,x,y,z``.
"""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.arrays import Bytes, Floats, Ints, Mask
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.files.plain_files import content_of
from geometry.frames import inverse, transform_points
from geometry.poses.register import LEAST_POINTS_CALIBRATED, LEAST_POINTS_UNCALIBRATED, Registration, register, suspect
from kb.errors import IntakeError, KBErrors, Mistake
from kb.files.folder import Document
from kb.files.quantities import LENGTHS
from kb.files.yaml_text import load
from kb.learning.observations import Observations
from kb.surfaces.surface import Surface

MOST = 1000
"""Points of one file."""
MAX_BYTES = 1_000_000


@dataclass(frozen=True, eq=False)
class Points:
    """N correspondences: ``uv`` (N, 2) px, ``at`` (N, 3) m, object frame, ``places`` (line, column) in ``file``."""

    file: str
    uv: NDArray[np.float64]
    at: NDArray[np.float64]
    places: tuple[tuple[int, int], ...]

    def mistake(self, index: int, message: str) -> Mistake:
        """What is wrong with one of the points, at its line and column."""
        line, column = self.places[index]
        return Mistake(self.file, line, column, f"points.{index}", message)


def read_points(path: Path, units: str | None = None) -> Points:
    """The correspondences of a file; ``units`` where it states none.

    Raises:
        IntakeError: there is no such file, or it is too large.
        KBErrors: every mistake in it.
    """
    content = content_of(path, MAX_BYTES, IntakeError)
    if path.suffix.lower() in (".csv", ".txt"):
        return _from_csv(path, content, LENGTHS[units or "m"])
    return _from_yaml(load(str(path), content), units)


def _from_yaml(document: Document, units: str | None) -> Points:
    mistakes = list(document.mistakes)
    data: Any = document.data
    rows: Any = data.get("points") if isinstance(data, dict) else None
    if not mistakes:
        mistakes += _shape_mistakes(document, data, rows)
    if mistakes:
        raise KBErrors(mistakes)
    scale = LENGTHS[data.get("units", units or "m")]
    numbers = []
    for i, row in enumerate(rows):
        found = _numbers(row)
        if isinstance(found, str):
            mistakes.append(document.mistake(("points", i), found))
        else:
            numbers.append(found)
    if mistakes:
        raise KBErrors(mistakes)
    return _points(document.file, numbers, scale, [document.place(("points", i)) for i in range(len(rows))])


def _shape_mistakes(document: Document, data: object, rows: object) -> list[Mistake]:
    if not isinstance(data, dict) or not isinstance(rows, list) or not 0 < len(rows) <= MOST:
        return [
            document.mistake(("points",), f"must be a mapping with points, a list of 1 to {MOST} of [u, v, x, y, z]")
        ]
    mistakes = [
        document.mistake((key,), "is no key of a file of points: units, points", key=True)
        for key in data
        if key not in ("units", "points")
    ]
    if "units" in data and (not isinstance(data["units"], str) or data["units"] not in LENGTHS):
        mistakes.append(document.mistake(("units",), f"must be one of {', '.join(LENGTHS)}, not {data['units']!r:.40}"))
    return mistakes


def _numbers(row: object) -> list[float] | str:
    """u, v, x, y, z of one point, or what is wrong with it."""
    if isinstance(row, dict):
        if set(row) != {"pixel", "at"} or not isinstance(row["pixel"], list) or not isinstance(row["at"], list):
            return "must be {pixel: [u, v], at: [x, y, z]}"
        if (len(row["pixel"]), len(row["at"])) != (2, 3):
            return f"must have two numbers of the pixel and three of the place, not {len(row['pixel'])} and {len(row['at'])}"
        row = [*row["pixel"], *row["at"]]
    if not isinstance(row, list) or len(row) != 5:
        return "must be five numbers: u, v of the pixel, x, y, z of the place"
    wrong = [value for value in row if isinstance(value, bool) or not isinstance(value, int | float)]
    return f"must be numbers, not {wrong[0]!r:.40}" if wrong else _finite(row)


def _finite(values: list[float]) -> list[float] | str:
    small = all(abs(value) < 1e9 for value in values)  # neither NaN nor an integer that no float can hold
    return [float(value) for value in values] if small else "must be finite numbers below 1e9"


def _from_csv(path: Path, content: bytes, scale: float) -> Points:
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise KBErrors([Mistake(str(path), 1 + content[: error.start].count(b"\n"), 1, "", "must be UTF-8")]) from None
    numbers: list[list[float]] = []
    mistakes, places = [], []
    for number, line in enumerate(lines, 1):
        cells = [cell.strip() for cell in line.split("#")[0].replace(";", ",").split(",")]
        if cells == [""] or (not numbers and [cell.lower() for cell in cells] == ["u", "v", "x", "y", "z"]):
            continue
        found = _cells(cells)
        if isinstance(found, tuple):
            column = 1 + sum(len(cell) + 1 for cell in line.split(",")[: found[0]])
            mistakes.append(Mistake(str(path), number, column, "", found[1]))
        else:
            numbers.append(found)
            places.append((number, 1))
    if len(numbers) > MOST:
        mistakes.append(
            Mistake(
                str(path), *places[MOST], "", f"is point {MOST + 1} of {len(numbers)}: a file may have {MOST} points"
            )
        )
    if not numbers and not mistakes:
        mistakes.append(Mistake(str(path), 1, 1, "", "holds no points: u,v,x,y,z a line"))
    if mistakes:
        raise KBErrors(mistakes)
    return _points(str(path), numbers, scale, places)


def _cells(cells: list[str]) -> list[float] | tuple[int, str]:
    """The five numbers of a line, or which cell is wrong and how."""
    if len(cells) != 5:
        return 0, f"must be five numbers u,v,x,y,z, not {len(cells)}"
    values: list[float] = []
    for i, cell in enumerate(cells):
        try:
            values.append(float(cell))
        except ValueError:
            return i, f"must be a number, not {cell!r:.40}"
        if isinstance(_finite(values), str):
            return i, "must be a finite number below 1e9"
    return values


def _points(file: str, numbers: list[list[float]], scale: float, places: list[tuple[int, int]]) -> Points:
    rows = np.array(numbers, dtype=np.float64).reshape(-1, 5)
    return Points(file, rows[:, :2], rows[:, 2:] * scale, tuple(places))


TOO_FAR = 0.1
"""Of a clicked place from the mesh's box, as a share of the mesh's diameter: beyond, its unit or its numbers are
wrong."""
HIDDEN = 0.05
"""A clicked place that the mesh itself hides by more than this share of its diameter is on the far side."""
OFF = 0.012, 2.0
"""Greatest rms of the clicks: this share of their spread on the photo, or so many pixels, whichever is more."""
GRAZING = np.radians(75.0)
"""A triangle turned farther from the line of sight is not painted: the photo shows too little of it."""
TRIANGLES = 12_000
"""About how many the mesh is cut into, so that each is nearly flat to the camera's perspective."""
GREY, STRIP = 128, 64
"""Grey level of what the photo does not show, and height in pixels of the grey strip under the photo that they are
painted with."""
SHARP = 1000.0
"""Pixels that the object's diameter has at least in the texture (a photo of it that is smaller is enlarged, up to four
times)."""
CLEAR = 1.0
"""Of its diameter: a keypoint nearer to a grey triangle that the same view shows owes itself to the paint's rim."""
SIDED = 8.0
"""Pixels: so does the side of an edge that is nearer."""


@dataclass(frozen=True, eq=False)
class PaintedMesh:
    """``vertices`` (V, 3) m, ``triangles`` (T, 3), ``uv`` (V, 2) with v upward, ``texture`` (H, W, 3).

    ``shown`` (T,): by the photo.
    """

    vertices: Floats
    triangles: Ints
    uv: Floats
    texture: Bytes
    shown: Mask


def registered(points: Points, size: tuple[int, int], surface: Surface, camera: Camera | None = None) -> Registration:
    """Camera and pose of a photo of ``size`` (width, height) px.

    Raises:
        KBErrors: points outside the photo, off the mesh, hidden by it, or one that does not fit the others: each at its
        line. IntakeError: too few points, or points that fix no pose or no focal length.
    """
    fewest = LEAST_POINTS_UNCALIBRATED if camera is None else LEAST_POINTS_CALIBRATED
    if len(points.at) < fewest:
        why = "without a camera (its focal length is sought too)" if camera is None else "with a camera"
        raise IntakeError(f"{points.file}: has {len(points.at)} points; {fewest} at least are needed {why}")
    _check_places(points, size, surface)
    try:
        found = register(points.at, points.uv, size, camera)
    except GeometryError as error:
        raise IntakeError(f"{points.file}: {error}") from error
    limit = max(OFF[0] * float(np.linalg.norm(np.ptp(points.uv, axis=0))), OFF[1])
    if found.rms > limit:
        worst = suspect(points.at, points.uv, size, camera)
        told = f"does not fit the others: {found.residuals[worst]:.1f} px off; the rms of all is {found.rms:.1f} px, {limit:.1f} px is the most"
        raise KBErrors([points.mistake(worst, told)])
    _check_seen(points, found, surface)
    return found


def _check_places(points: Points, size: tuple[int, int], surface: Surface) -> None:
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    away = np.linalg.norm(points.at - np.clip(points.at, low, high), axis=1)
    width, height = size
    outside = ((points.uv < -0.5) | (points.uv > np.array([width, height]) - 0.5)).any(axis=1)
    wrong = [
        points.mistake(int(i), f"the pixel must lie in the photo of {width} x {height}")
        for i in np.flatnonzero(outside)
    ]
    for i in np.flatnonzero(away > TOO_FAR * surface.diameter):
        told = f"is {away[i]:.3g} m from the mesh, whose diameter is {surface.diameter:.3g} m: are its numbers and the units right?"
        wrong.append(points.mistake(int(i), told))
    if wrong:
        raise KBErrors(wrong)


def _check_seen(points: Points, found: Registration, surface: Surface) -> None:
    hidden = surface.rays.blocks(inverse(found.camera_from_object)[:3, 3], points.at, HIDDEN * surface.diameter)
    told = "is on the far side of the object in the pose that all points give: is its place right?"
    wrong = [points.mistake(int(i), told) for i in np.flatnonzero(hidden)]
    if wrong:
        raise KBErrors(wrong)


def painted(surface: Surface, photo: Bytes, camera: Camera, camera_from_object: Floats) -> PaintedMesh:
    """The mesh cut finely and painted with the photo (H, W, 3), blue first.

    Raises:
        IntakeError: the photo shows nothing of the mesh.
    """
    corners = _cut(surface)
    shown = _shown(surface, corners, camera, camera_from_object)
    if not shown.any():
        raise IntakeError("the photo shows no face of the mesh: it is outside, or seen along its faces only")
    placed = transform_points(camera_from_object, corners.reshape(-1, 3))
    pixels = np.nan_to_num(camera.project(placed))
    height, width = photo.shape[:2]
    factor = _enlargement(placed, camera, surface.diameter)
    whole = height + STRIP
    uv = np.stack([(pixels[:, 0] + 0.5) / width, 1.0 - (pixels[:, 1] + 0.5) / whole], axis=1)
    uv[~np.repeat(shown, 3)] = (0.5, 0.5 * STRIP / whole)
    rows, triangles = np.unique(np.column_stack([corners.reshape(-1, 3), uv]), axis=0, return_inverse=True)
    return PaintedMesh(rows[:, :3], triangles.reshape(-1, 3), rows[:, 3:], _texture(photo, factor), shown)


def _cut(surface: Surface) -> Floats:
    """(T, 3, 3) corners of triangles whose sides are no longer than about ``TRIANGLES`` of them need on the surface."""
    corners = surface.vertices[surface.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2.0
    longest = 2.5 * np.sqrt(area / TRIANGLES)
    done = []
    while len(corners):
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        small = sides.max(axis=1) <= longest
        done.append(corners[small])
        corners, which = corners[~small], sides[~small].argmax(axis=1)
        turned = corners[np.arange(len(corners))[:, None], (which[:, None] + np.arange(3)) % 3]
        middle = turned[:, :2].mean(axis=1)
        corners = np.concatenate(
            [
                np.stack([turned[:, 0], middle, turned[:, 2]], axis=1),
                np.stack([middle, turned[:, 1], turned[:, 2]], axis=1),
            ]
        )
    return np.concatenate(done)


def _shown(surface: Surface, corners: Floats, camera: Camera, camera_from_object: Floats) -> Mask:
    """(T,) which triangles face the camera, not too aslant, are in the image, and are hidden at no corner."""
    eye = inverse(camera_from_object)[:3, 3]
    middle = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    line = eye - middle
    lengths = np.linalg.norm(normal, axis=1) * np.linalg.norm(line, axis=1)
    shown = (normal * line).sum(axis=1) > np.cos(GRAZING) * lengths
    inset = np.concatenate([middle[:, None], corners + 0.05 * (middle[:, None] - corners)], axis=1)
    pixels = camera.project(transform_points(camera_from_object, inset.reshape(-1, 3)))
    shown &= camera.contains(pixels).reshape(-1, 4).all(axis=1)
    shown &= ~surface.rays.blocks(eye, inset.reshape(-1, 3), 1e-4 * surface.diameter).reshape(-1, 4).any(axis=1)
    return np.asarray(shown)


def _enlargement(placed: Floats, camera: Camera, diameter: float) -> int:
    across = camera.f * diameter / max(float(np.median(placed[:, 2])), 1e-9)
    return int(np.clip(np.ceil(SHARP / max(across, 1.0)), 1, 4))


def _texture(photo: Bytes, factor: int) -> Bytes:
    grey = np.full((STRIP * factor, photo.shape[1] * factor, 3), GREY, np.uint8)
    large = (
        np.asarray(cv2.resize(photo, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC), np.uint8)
        if factor > 1
        else photo
    )
    return np.concatenate([large, grey])


def on_shown(mesh: PaintedMesh, seen: Observations) -> Observations:
    """The observations that owe nothing to the grey.

    On a shown triangle, and not near a grey one that their view shows as well.
    """
    corners = mesh.vertices[mesh.triangles]
    middle = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    keep = np.zeros(len(seen), bool)
    for view in np.unique(seen.view):
        rows = np.flatnonzero(seen.view == view)
        direction = seen.direction[rows].mean(axis=0)
        facing = normal @ direction > 0.0
        if not (facing & mesh.shown).any():
            continue
        to_shown = cKDTree(middle[facing & mesh.shown]).query(seen.at[rows])[0]
        grey = facing & ~mesh.shown
        to_grey = cKDTree(middle[grey]).query(seen.at[rows])[0] if grey.any() else np.full(len(rows), np.inf)
        keep[rows] = (to_shown < to_grey) & (
            to_grey > np.where(seen.sided[rows], SIDED * seen.pixel[rows], CLEAR * seen.size[rows])
        )
    return replace(seen, **{field.name: getattr(seen, field.name)[keep] for field in fields(seen)})
