"""Log weights as whole numbers of units, so that sums are exact and equal weights are equal.

Sums of floating-point numbers depend on their order: a bound and the weight that it bounds then differ by noise, and
ties come out at random. Here a table becomes *costs*: how many units of ``2^−42`` (2.3e-13) its entries lie below its
greatest entry, rounded once per entry; all later sums are exact. What is summed up before, in doubles, are the tables
of one small piece or bucket: noise far below a tie (``ranked``). A table with a range so wide that its piece's costs
would not fit in 64 bits keeps fewer digits, down to ``2^−36`` (1.5e-11), and past that is in Python's own integers, of
any size.

* ``Costs(-1.3, [array([0, 7]), ...], 2**58, 0)``: the greatest entries' sum; costs ≥ 0 by table, in units of
  ``2^−42 << shift``; the cost that stands for impossible
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

    Table = NDArray[Any]  # int64, or Python's integers as objects

_CELLS = attrgetter("size")
DIGITS = 42  # binary digits behind the point
FEWEST = 36  # digits that 64-bit costs keep at least
ROOM = 57  # every possible cost of a piece is below 2^57
IMPOSSIBLE = 1 << (ROOM + 1)  # so that 31 of them still fit in 64 bits


class Costs(NamedTuple):
    """A piece's tables as costs, in their order, flattened, below ``top``; sums of ``impossible`` and more are impossible."""

    top: float
    tables: Sequence[Table]
    impossible: int
    shift: int


def costs(tables: Sequence[NDArray[np.float64]]) -> Costs | None:
    """The costs of a piece's tables; None if some table allows nothing."""
    if not tables:
        return Costs(0.0, [], IMPOSSIBLE, 0)
    flat = np.concatenate(tables, axis=None)
    sizes = list(map(_CELLS, tables))
    cuts = list(accumulate(sizes, initial=0))
    tops = np.maximum.reduceat(flat, np.array(cuts[:-1]))
    if tops.min() == -np.inf:
        return None
    greatest = tops.repeat(sizes)
    below = greatest - flat
    impossible, shift = IMPOSSIBLE, 0
    if ((below >= 2.0 ** (ROOM - DIGITS) / len(tables)) & (below < np.inf)).any():
        units, impossible, shift = _scaled(below, greatest, flat, cuts)
    else:
        np.minimum(below, 2.0 ** (ROOM + 1 - DIGITS), out=below)
        below *= 2.0**DIGITS
        units = np.rint(below, out=below).astype(np.int64)
    own = [units[start:stop] for start, stop in pairwise(cuts)]
    return Costs(math.fsum(tops.tolist()), own, impossible, shift)


def _scaled(
    below: NDArray[np.float64],
    greatest: NDArray[np.float64],
    flat: NDArray[np.float64],
    cuts: Sequence[int],
) -> tuple[Table, int, int]:
    """(all costs, the impossible cost, the shift), in as many digits as the range leaves room for."""
    ranges = np.maximum.reduceat(np.where(below < np.inf, below, 0.0), cuts[:-1])
    span = sum(ranges.tolist())
    digits = DIGITS if span < 2.0 ** (ROOM - DIGITS) else ROOM - 1 - math.ceil(math.log2(span))
    if digits >= FEWEST:
        return (
            np.where(below < np.inf, np.rint(below * 2.0**digits), float(IMPOSSIBLE)).astype(np.int64),
            IMPOSSIBLE,
            DIGITS - digits,
        )
    values = [
        None if x == -math.inf else in_units(top) - in_units(x)
        for top, x in zip(greatest.tolist(), flat.tolist(), strict=True)
    ]
    impossible = 2 * sum([x for x in values if x is not None]) + 1
    own = np.empty(len(values), dtype=object)
    own[:] = [impossible if x is None else x for x in values]
    return own, impossible, 0


def in_units(weight: float) -> int:
    """Units, to the nearest; past 2^53 a double is whole anyway, and times 2^42 might overflow."""
    return int(weight) << DIGITS if abs(weight) > 2.0**53 else round(weight * 2.0**DIGITS)
