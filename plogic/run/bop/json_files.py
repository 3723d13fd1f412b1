"""BOP's JSON files, read with care: every mistake is one line ``FILE: KEY: what is wrong``."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.files.documents import read_json as document_of
from geometry.files.plain_files import fault_of
from geometry.frames import from_rotation_translation
from plogic.base.errors import InputError

LARGEST = 256 * 2**20
"""Bytes of a JSON file."""
CROOKED = 1e-2
"""How far a rotation may be off orthonormal: datasets round theirs; the nearest rotation is taken."""
HIGHEST = 10**9
"""What every number of theirs stays below: scenes, images and objects, millimetres, pixels."""
MM = 1000.0
"""Millimetres in a metre."""


def read_json(path: Path) -> Any:  # noqa: ANN401 - parsed JSON
    """The document of a file. Raises InputError that names it."""
    return document_of(path, LARGEST, "a BOP file holds lists of objects and of numbers", InputError).data


def numbered(path: Path) -> dict[int, Any]:
    """A JSON object whose keys are numbers of images or objects, ``{"0": ..., "1": ...}``, in a plain file."""
    fault = fault_of(path)
    if fault is not None:
        raise InputError(f"{path}: {fault}")
    content = read_json(path)
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be an object with numbers as keys, not {shown(content)}")
    found: dict[int, Any] = {}
    for key, value in content.items():
        if number_of(key) is None:
            raise InputError(f"{path}: {shown(key)}: must be a whole number below {HIGHEST}")
        if int(key) in found:
            raise InputError(f"{path}: {shown(key)}: is there twice")
        found[int(key)] = value
    return found


def number_of(text: str) -> int | None:
    """The whole number below ``HIGHEST`` that a text is, zeros before it or not; None for any other text."""
    plain = text.isascii() and text.isdigit() and len(text.lstrip("0")) < len(str(HIGHEST))
    return int(text) if plain else None


def entry_of(entries: Mapping[int, Any], number: int, path: Path) -> Any:  # noqa: ANN401 - parsed JSON
    """What a file has under a number; a mistake where it has nothing."""
    if number not in entries:
        raise InputError(f"{path}: {number}: is missing")
    return entries[number]


def member(entry: object, key: str, place: str) -> Any:  # noqa: ANN401 - parsed JSON
    """``entry[key]``; ``place`` is the file and the keys above."""
    if not isinstance(entry, dict):
        raise InputError(f"{place}: must be an object, not {shown(entry)}")
    if key not in entry:
        raise InputError(f"{place}.{key}: is missing")
    return entry[key]


def whole(value: object, place: str) -> int:
    """A whole number that is not negative."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < HIGHEST:
        raise InputError(f"{place}: must be a whole number from 0 and below {HIGHEST}, not {shown(value)}")
    return value


def numbers(value: object, count: int, place: str) -> NDArray[np.float64]:
    """``count`` finite numbers, nested or not, as (count,)."""
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.zeros(0)
    if array.dtype.kind not in "iuf" or array.size != count or not (np.abs(array.astype(np.float64)) < HIGHEST).all():
        raise InputError(f"{place}: must hold {count} finite numbers below {HIGHEST:g}, not {shown(value)}")
    return array.astype(np.float64).ravel()


def fraction(value: object, place: str) -> float:
    """A number from 0 to 1."""
    number = float(numbers(value, 1, place)[0])
    if not 0.0 <= number <= 1.0:
        raise InputError(f"{place}: must be from 0 to 1, not {number:g}")
    return number


def motion(R: NDArray[np.float64], t_mm: NDArray[np.float64], place: str) -> NDArray[np.float64]:
    """The rigid motion (4, 4), metres, of BOP's 9 and 3 numbers, millimetres; the nearest rotation to a rounded one."""
    u, sizes, v = np.linalg.svd(R.reshape(3, 3))
    if np.abs(sizes - 1).max() > CROOKED or np.linalg.det(u @ v) < 0:
        raise InputError(f"{place}: must be a rotation, row by row, not {shown(R.tolist())}")
    return np.asarray(from_rotation_translation(u @ v, t_mm / MM))


def shown(value: object) -> str:
    """A value in a message, cut short."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
