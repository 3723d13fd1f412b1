"""Log weights as whole numbers of units, so that sums are exact and equal weights are equal.

Sums of floating-point numbers depend on their order: a bound and the weight that it bounds then differ by noise, and ties come out at
random. Here a table becomes *costs*: how many units of ``2^−42`` (2.3e-13) its entries lie below its greatest entry, rounded once per
entry; all later sums are exact. A table with a range so wide that its piece's costs would not fit in 64 bits keeps fewer digits, down to
``2^−36`` (1.5e-11), and past that is in Python's own integers, of any size.

* ``Costs((array([0, 7]), ...), 2**58, 0)``: costs ≥ 0 in units, by table; the cost that stands for impossible; units are ``2^−42 << shift``
"""

from __future__ import annotations

import math
from itertools import accumulate
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.inference.parts import Part

    Table = NDArray[Any]  # int64, or Python's integers as objects

DIGITS = 42  # binary digits behind the point
FEWEST = 36  # digits that 64-bit costs keep at least
ROOM = 57  # every possible cost of a piece is below 2^57
IMPOSSIBLE = 1 << (ROOM + 1)  # so that 31 of them still fit in 64 bits


class Costs(NamedTuple):
    """One piece's tables as costs, in the piece's order, flattened; sums of ``impossible`` and more are impossible."""

    tables: tuple[Table, ...]
    impossible: int
    shift: int


def costs(parts: Sequence[Part]) -> tuple[float, list[Costs]] | None:
    """(sum of the tables' greatest entries, costs of each piece); None if some table allows nothing."""
    tables = [table for part in parts for _, table in part.tables]
    if not tables:
        return 0.0, [Costs((), IMPOSSIBLE, 0) for _ in parts]
    flat = np.concatenate(tables, axis=None)
    sizes = [table.size for table in tables]
    cuts = list(accumulate(sizes, initial=0))
    tops = np.maximum.reduceat(flat, cuts[:-1])
    if tops.min() == -np.inf:
        return None
    greatest = tops.repeat(sizes)
    below = greatest - flat
    units = np.rint(np.minimum(below, 2.0 ** (ROOM + 1 - DIGITS)) * 2.0**DIGITS).astype(np.int64)
    most = max([len(part.tables) for part in parts])
    narrow = not ((below >= 2.0 ** (ROOM - DIGITS) / most) & (below < np.inf)).any()
    result, at = [], 0
    for part in parts:
        end = at + len(part.tables)
        own, impossible, shift = (units, IMPOSSIBLE, 0) if narrow else _scaled(greatest, flat, units, cuts[at : end + 1])
        result.append(Costs(tuple([own[start:stop] for start, stop in zip(cuts[at:end], cuts[at + 1 : end + 1], strict=True)]), impossible, shift))
        at = end
    return math.fsum(tops.tolist()), result


def _scaled(greatest: NDArray[np.float64], flat: NDArray[np.float64], units: Table, cuts: Sequence[int]) -> tuple[Table, int, int]:
    """(costs of one piece at their places in an array of all, its impossible cost, its shift): as many digits as its range leaves room for."""
    if len(cuts) < 2:
        return units, IMPOSSIBLE, 0
    mine = slice(cuts[0], cuts[-1])
    below = greatest[mine] - flat[mine]
    ranges = np.maximum.reduceat(np.where(below < np.inf, below, 0.0), [cut - cuts[0] for cut in cuts[:-1]])
    span = sum(ranges.tolist())
    digits = DIGITS if span < 2.0 ** (ROOM - DIGITS) else ROOM - 1 - math.ceil(math.log2(span))
    own = np.zeros(len(flat), dtype=np.int64 if digits >= FEWEST else object)
    if digits >= FEWEST:
        own[mine] = np.where(below < np.inf, np.rint(below * 2.0**digits), float(IMPOSSIBLE)).astype(np.int64)
        return own, IMPOSSIBLE, DIGITS - digits
    values = [None if x == -math.inf else _whole(top) - _whole(x) for top, x in zip(greatest[mine].tolist(), flat[mine].tolist(), strict=True)]
    impossible = 2 * sum([x for x in values if x is not None]) + 1
    own[mine] = [impossible if x is None else x for x in values]
    return own, impossible, 0


def _whole(weight: float) -> int:
    """Units, to the nearest; past 2^53 a double is whole anyway, and times 2^42 might overflow."""
    return int(weight) << DIGITS if abs(weight) > 2.0**53 else round(weight * 2.0**DIGITS)
