"""BOP's JSON files, read with care: every mistake is one line ``FILE:LINE:COLUMN: KEY: what is wrong``."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import digits
from geometry.arrays import numbers_of
from geometry.errors import Keys, Mistake
from geometry.files.documents import Document
from geometry.files.documents import read_json as document_of
from geometry.files.plain_files import fault_of
from geometry.frames import from_rotation_translation
from plogic.base.errors import InputError

LARGEST = 256 * 2**20
"""Bytes of a JSON file."""
SEARCHED = 4 * 2**20
"""Bytes of a file in which the place of a mistake is looked up."""
CROOKED = 1e-2
"""How far a rotation may be off orthonormal: datasets round theirs; the nearest rotation is taken."""
HIGHEST = 10**9
"""What every number of theirs stays below: scenes, images and objects, millimetres, pixels."""
MM = 1000.0
"""Millimetres in a metre."""


def read_json(path: Path) -> Any:  # noqa: ANN401 - parsed JSON
    """The document of a file. Raises InputError that names it."""
    return _document(path).data


def _document(path: Path) -> Document:
    return document_of(path, LARGEST, "a BOP file holds lists of objects and of numbers", InputError)


@dataclass(frozen=True)
class Place:
    """A value in a file; as a text, its line and column and the keys that lead to it.

    The file is read again for that, as its text is not kept for mistakes that hardly any file has; of one of more than
    ``SEARCHED`` bytes, which might have very many, the keys alone are told.
    """

    path: Path
    keys: Keys = ()

    def at(self, *keys: str | int) -> "Place":
        """What stands below it under these keys."""
        return Place(self.path, (*self.keys, *keys))

    def __str__(self) -> str:
        dotted = f": {'.'.join(f'{key!s:.60}' for key in self.keys)}" if self.keys else ""
        if fault_of(self.path, SEARCHED) is not None:
            return f"{self.path}{dotted}"
        try:
            document = _document(self.path)
        except InputError:  # it is gone, or another
            return f"{self.path}{dotted}"
        (where,) = document.where([Mistake(_as_written(document.data, self.keys), "")])
        return f"{where}{dotted}"


def _as_written(document: Any, keys: Keys) -> Keys:  # noqa: ANN401 - parsed JSON
    """The keys as far as they lead, numbers of images and objects as the file writes them."""
    found: list[str | int] = []
    for key in keys:
        if isinstance(document, dict):
            same = (k for k in document if k == str(key) or (number_of(k) is not None and str(int(k)) == str(key)))
            step: str | int | None = next(same, None)
        else:
            step = key if isinstance(document, list) and isinstance(key, int) and key < len(document) else None
        if step is None:
            break
        found.append(step)
        document = document[step]
    return tuple(found)


def numbered(path: Path) -> dict[int, Any]:
    """A JSON object whose keys are numbers of images or objects, ``{"0": ..., "1": ...}``, in a plain file."""
    fault = fault_of(path)
    if fault is not None:
        raise InputError(f"{path}: {fault}")
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError(f"{Place(path)}: must be an object with numbers as keys, not {shown(content)}")
    found: dict[int, Any] = {}
    for key, value in content.items():
        if number_of(key) is None:
            raise InputError(f"{Place(path, (key,))}: must be a whole number below {HIGHEST}")
        if int(key) in found:
            raise InputError(f"{Place(path, (key,))}: is there twice")
        found[int(key)] = value
    return found


def number_of(text: str) -> int | None:
    """The whole number below ``HIGHEST`` that a text is, zeros before it or not; None for any other text."""
    return digits.whole(text, HIGHEST - 1)


def entry_of(entries: Mapping[int, Any], number: int, path: Path) -> Any:  # noqa: ANN401 - parsed JSON
    """What a file has under a number; a mistake where it has nothing."""
    if number not in entries:
        raise InputError(f"{Place(path, (number,))}: is missing")
    return entries[number]


def member(entry: object, key: str, place: Place) -> Any:  # noqa: ANN401 - parsed JSON
    """``entry[key]``; ``place`` is that of the entry."""
    if not isinstance(entry, dict):
        raise InputError(f"{place}: must be an object, not {shown(entry)}")
    if key not in entry:
        raise InputError(f"{place.at(key)}: is missing")
    return entry[key]


def whole(value: object, place: Place) -> int:
    """A whole number that is not negative."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < HIGHEST:
        raise InputError(f"{place}: must be a whole number from 0 and below {HIGHEST}, not {shown(value)}")
    return value


def numbers(value: object, count: int, place: Place) -> NDArray[np.float64]:
    """``count`` finite numbers, nested or not, as (count,)."""
    found = numbers_of(value, count, HIGHEST)
    if found is None:
        raise InputError(f"{place}: must hold {count} finite numbers below {HIGHEST:g}, not {shown(value)}")
    return found


def fraction(value: object, place: Place) -> float:
    """A number from 0 to 1."""
    number = float(numbers(value, 1, place)[0])
    if not 0.0 <= number <= 1.0:
        raise InputError(f"{place}: must be from 0 to 1, not {number:g}")
    return number


def motion(R: NDArray[np.float64], t_mm: NDArray[np.float64], place: Place) -> NDArray[np.float64]:
    """The rigid motion (4, 4), metres, of BOP's 9 and 3 numbers, millimetres; the nearest rotation to a rounded one."""
    u, sizes, v = np.linalg.svd(R.reshape(3, 3))
    if np.abs(sizes - 1).max() > CROOKED or np.linalg.det(u @ v) < 0:
        raise InputError(f"{place}: must be a rotation, row by row, not {shown(R.tolist())}")
    return np.asarray(from_rotation_translation(u @ v, t_mm / MM))


def shown(value: object) -> str:
    """A value in a message, cut short."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
