"""Clicked correspondences: pixels of a photo and the places of the object that they show, from a small text.

YAML or JSON, a mapping with ``units`` (m where it is missing) and ``points``, each ``[u, v, x, y, z]`` or ``{pixel: [u,
v], at: [x, y, z]}``; or CSV, five numbers a line in the unit that is handed in, with or without the header
``u,v,x,y,z``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kb.errors import IntakeError, KBErrors, Mistake
from kb.files.values import LENGTHS
from kb.files.yaml_text import Document, load

MOST = 1000
"""Points of one file."""
MAX_BYTES = 1_000_000


@dataclass(frozen=True, eq=False)
class Points:
    """N correspondences: ``uv`` (N, 2) pixels, ``at`` (N, 3) metres in the object's frame, ``places`` (line, column) of each in ``file``."""

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
    try:
        content = path.read_bytes() if path.stat().st_size <= MAX_BYTES else None
    except OSError as error:
        raise IntakeError(f"{path}: cannot be read: {error.strerror}") from None
    if content is None:
        raise IntakeError(f"{path}: is larger than the {MAX_BYTES} bytes that a file of points may have")
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
