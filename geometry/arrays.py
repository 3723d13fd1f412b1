"""Arrays that are checked once and can never be written again."""

import math
from collections.abc import Iterable
from functools import reduce
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.errors import GeometryError
from geometry.room import MB, check_room

Floats = NDArray[np.float64]  # any shape, double precision
Ints = NDArray[np.int64]  # any shape
Indices = NDArray[np.intp]  # any shape, what numpy takes as an index
Mask = NDArray[np.bool_]  # any shape
Bytes = NDArray[np.uint8]  # any shape: pixels, descriptors

Number = TypeVar("Number", bound=np.generic)

PRODUCT = 32 * MB
"""Bytes that OpenBLAS takes at the first product, and ends the process without: here, where they are asked for.

One that is large enough: with AVX-512, 2×2 takes none.
"""
check_room(PRODUCT)
np.dot(np.eye(200), np.ones(200))


def frozen(values: ArrayLike) -> Floats:
    """A read-only copy of `values` as doubles; later writes to the original do not reach it."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def frozen_ints(values: ArrayLike) -> Ints:
    """A read-only copy of `values` as 64-bit integers."""
    array = np.array(values, dtype=np.int64)
    array.setflags(write=False)
    return array


def last_axes(values: ArrayLike, shape: Iterable[int], name: str) -> Floats:
    """`values` as doubles whose last axes have `shape` (-1: any length).

    Raises:
        GeometryError: naming `name`, the rule and the shape that came.
    """
    array = np.asarray(values, dtype=np.float64)
    wanted = tuple(shape)
    tail = array.shape[array.ndim - len(wanted) :] if array.ndim >= len(wanted) else ()
    if tail != wanted and not (len(tail) == len(wanted) and all(map(_fits, wanted, tail))):
        rule = ", ".join("N" if want == -1 else str(want) for want in wanted)
        raise GeometryError(f"{name} must have the shape (..., {rule}), not {array.shape}")
    return array


def _fits(want: int, got: int) -> bool:
    return want in (-1, got)


def summed(values: Floats) -> Floats:
    """The sums (...) over a last axis of two to seven, added in its order, which is far quicker than numpy's own."""
    return reduce(np.add, (values[..., axis] for axis in range(values.shape[-1])))


def lengths(vectors: Floats) -> Floats:
    """The Euclidean lengths (...) along such an axis."""
    return np.asarray(np.sqrt(summed(vectors * vectors)))


def pieces(rows: NDArray[Number], each: int, most: int) -> list[NDArray[Number]]:
    """`rows` (N, ...) cut so that no piece makes more than `most` of anything where one row makes `each`."""
    size = max(1, most // max(each, 1))
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def numbers_of(value: object, count: int, below: float = math.inf) -> Floats | None:
    """So many numbers of a document, in lists of lists or not, as (count,); None of anything else.

    Each is finite, and nearer to 0 than ``below``: whole numbers of any length are none.
    """
    try:
        found = np.asarray(value)
    except (ValueError, OverflowError):
        return None
    if found.dtype.kind not in "iuf" or found.size != count:
        return None
    numbers = found.astype(np.float64).ravel()
    return numbers if (np.abs(numbers) < below).all() else None
