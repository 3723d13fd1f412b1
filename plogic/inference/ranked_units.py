"""Log weights as whole numbers of units, so that sums are exact and equal weights are equal.

Sums of floating-point numbers depend on their order: a bound and the weight that it bounds then differ by noise, and ties come out at
random. Here a table becomes *costs*: how many units of ``2^−42`` (2.3e-13) its entries lie below its greatest entry, rounded once per
entry; all later sums are exact. A table with a range so wide that its piece's costs would not fit in 64 bits keeps fewer digits, down to
``2^−36`` (1.5e-11), and past that is in Python's own integers, of any size.

* ``Costs([array([0, 7]), ...], 2**58, 0)``: costs ≥ 0 in units, by table; the cost that stands for impossible; units are ``2^−42 << shift``
"""

from __future__ import annotations

import math
from itertools import accumulate, pairwise
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.inference.parts import Part

    Table = NDArray[Any]  # int64, or Python's integers as objects

_CELLS = attrgetter("size")
DIGITS = 42  # binary digits behind the point
FEWEST = 36  # digits that 64-bit costs keep at least
ROOM = 57  # every possible cost of a piece is below 2^57
IMPOSSIBLE = 1 << (ROOM + 1)  # so that 31 of them still fit in 64 bits


class Costs(NamedTuple):
    """One piece's tables as costs, in the piece's order, flattened; sums of ``impossible`` and more are impossible."""

    tables: Sequence[Table]
    impossible: int
    shift: int


def costs(parts: Sequence[Part]) -> tuple[float, list[Costs]] | None:
    """(sum of the tables' greatest entries, costs of each piece); None if some table allows nothing."""
    tables = [table for part in parts for _, table in part.tables]
    if not tables:
        return 0.0, [Costs([], IMPOSSIBLE, 0) for _ in parts]
    flat = np.concatenate(tables, axis=None)
    sizes = list(map(_CELLS, tables))
    cuts = list(accumulate(sizes, initial=0))
    tops = np.maximum.reduceat(flat, np.array(cuts[:-1]))
    if tops.min() == -np.inf:
        return None
    greatest = tops.repeat(sizes)
    below = greatest - flat
    units = np.rint(np.minimum(below, 2.0 ** (ROOM + 1 - DIGITS)) * 2.0**DIGITS).astype(np.int64)
    most = max([len(part.tables) for part in parts])
    narrow = not ((below >= 2.0 ** (ROOM - DIGITS) / most) & (below < np.inf)).any()
    cut = [units[start:stop] for start, stop in pairwise(cuts)] if narrow else []
    result, at = [], 0
    for part in parts:
        end = at + len(part.tables)
        result.append(Costs(cut[at:end], IMPOSSIBLE, 0) if narrow else _scaled(greatest, flat, units, cuts[at : end + 1]))
        at = end
    return math.fsum(tops.tolist()), result


def _scaled(greatest: NDArray[np.float64], flat: NDArray[np.float64], units: Table, cuts: Sequence[int]) -> Costs:
    """The costs of one piece, in as many digits as its range leaves room for."""
    own, impossible, shift = _whole_piece(greatest, flat, cuts) if len(cuts) > 1 else (units, IMPOSSIBLE, 0)
    return Costs([own[start - cuts[0] : stop - cuts[0]] for start, stop in pairwise(cuts)], impossible, shift)


def _whole_piece(greatest: NDArray[np.float64], flat: NDArray[np.float64], cuts: Sequence[int]) -> tuple[Table, int, int]:
    """(all costs of one piece, its impossible cost, its shift)."""
    mine = slice(cuts[0], cuts[-1])
    below = greatest[mine] - flat[mine]
    ranges = np.maximum.reduceat(np.where(below < np.inf, below, 0.0), [cut - cuts[0] for cut in cuts[:-1]])
    span = sum(ranges.tolist())
    digits = DIGITS if span < 2.0 ** (ROOM - DIGITS) else ROOM - 1 - math.ceil(math.log2(span))
    if digits >= FEWEST:
        return np.where(below < np.inf, np.rint(below * 2.0**digits), float(IMPOSSIBLE)).astype(np.int64), IMPOSSIBLE, DIGITS - digits
    values = [None if x == -math.inf else _whole(top) - _whole(x) for top, x in zip(greatest[mine].tolist(), flat[mine].tolist(), strict=True)]
    impossible = 2 * sum([x for x in values if x is not None]) + 1
    own = np.empty(len(values), dtype=object)
    own[:] = [impossible if x is None else x for x in values]
    return own, impossible, 0


def _whole(weight: float) -> int:
    """Units, to the nearest; past 2^53 a double is whole anyway, and times 2^42 might overflow."""
    return int(weight) << DIGITS if abs(weight) > 2.0**53 else round(weight * 2.0**DIGITS)
