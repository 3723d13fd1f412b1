"""What one bucket tells its parent: the product of what enters it, summed over its residual.

A small table, and one whose entries differ by more than floats can hold, is multiplied as logarithms. A large one is
multiplied as plain numbers, several times faster, but only where the spreads of all that enters it (ln of greatest over
least positive entry, measured) sum to less than ``MOST_SPREAD``: then no positive product can underflow, and both ways
agree to rounding.

* ``Message(values)``: what enters a bucket, a given table or what a child tells; the scale that was taken out of it is
  kept apart
* ``Weighed(weights, totals)``: shape (separator, residual) and (separator,): weights ÷ totals is P(residual |
  separator)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

MOST_SPREAD = 600.0  # e^-600 is 1e-261: far above the least positive double, 1e-308
LARGE_PRODUCT = 1 << 12  # cells from which plain numbers pay
FEW_COLUMNS = 16  # columns that are rather taken one by one
RUN_CELLS = 1 << 10  # cells of the contiguous runs in which a small table is multiplied into a large one


@dataclass
class Message:
    """``values`` as logarithms (``log``), impossible −inf, or plain with greatest 1, impossible 0.

    ``spread``: ≥ ln(greatest ÷ least positive).

    ``top`` is the greatest logarithm, known once it is ``measured``.
    """

    values: NDArray[np.float64]
    log: bool = True
    spread: float = math.inf
    top: float = 0.0

    def measured(self) -> float:
        """The spread; looks at the values where what is known is of no use."""
        if self.spread > MOST_SPREAD / 2:
            possible = self.values[self.values > (-np.inf if self.log else 0.0)]
            if not possible.size:
                self.spread = 0.0
            elif self.log:
                self.top = float(possible.max())
                self.spread = self.top - float(possible.min())
            else:
                self.spread = -math.log(possible.min())
        return self.spread

    def plain(self) -> NDArray[np.float64]:
        """Plain numbers, e^−``top`` times; only where a measured spread allows it."""
        return np.exp(self.values - self.top) if self.log else self.values

    def logs(self) -> NDArray[np.float64]:
        """Natural logarithms."""
        return self.values if self.log else np.log(self.values)


@dataclass
class Weighed:
    """A bucket's own table, kept for the way down."""

    weights: NDArray[np.float64]
    totals: NDArray[np.float64]


def weigh(entering: Sequence[Message], shape: Sequence[int], shared: int) -> tuple[Weighed, Message, float] | None:
    """(the table, the message over its first ``shared`` axes, the log scale taken out); None if nothing is possible.

    What enters has as many axes as ``shape``, of its length or 1.
    """
    rows, columns = math.prod(shape[:shared]), math.prod(shape[shared:])
    if rows * columns >= LARGE_PRODUCT:
        spread = sum(message.measured() for message in entering)
        if spread < MOST_SPREAD:
            return _plain(entering, shape, rows, spread)
    return _log(entering, shape, rows)


def _log(entering: Sequence[Message], shape: Sequence[int], rows: int) -> tuple[Weighed, Message, float] | None:
    table = np.zeros(shape)
    for message in entering:
        table += message.logs()
    weights = table.reshape(rows, -1)
    tops = weights.max(axis=1)
    top = tops.max()
    if top == -np.inf:
        return None
    if rows == 1:
        weights = np.exp(weights - top)
        totals = weights.sum(axis=1)
        return Weighed(weights, totals), Message(np.zeros(1)), float(top) + math.log(totals[0])
    tops[tops == -np.inf] = 0.0
    weights -= tops[:, None]
    np.exp(weights, out=weights)
    totals = weights.sum(axis=1)
    values = np.log(totals) + tops
    top = float(values.max())
    values -= top
    return Weighed(weights, totals), Message(values), top


def _plain(
    entering: Sequence[Message], shape: Sequence[int], rows: int, spread: float
) -> tuple[Weighed, Message, float] | None:
    table = _product([message.plain() for message in entering], shape)
    weights = table.reshape(rows, -1)
    totals = row_sums(weights)
    top = float(totals.max())
    if top == 0.0:
        return None
    message = Message(totals / top, log=False, spread=spread + math.log(weights.shape[1]))
    return Weighed(weights, totals), message, math.log(top) + math.fsum(one.top for one in entering)


def row_sums(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum of each row of a table with many rows: by columns, where numpy would start anew for every short row."""
    if table.shape[1] > FEW_COLUMNS:
        return np.add.reduce(table, axis=1)
    totals = table[:, 0].copy()
    for column in range(1, table.shape[1]):
        totals += table[:, column]
    return totals


def column_sums(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum of each column, likewise."""
    if table.shape[1] > FEW_COLUMNS:
        return np.add.reduce(table, axis=0)
    return np.array([np.add.reduce(table[:, column]) for column in range(table.shape[1])])


def _product(arrays: Sequence[NDArray[np.float64]], shape: Sequence[int]) -> NDArray[np.float64]:
    """The product over the whole shape: the small ones first, in contiguous runs, then the large ones in place."""
    ordered = sorted(arrays, key=lambda a: a.size)
    small = np.ones((1,) * len(shape))
    while ordered and ordered[0].size < RUN_CELLS:
        small = small * ordered.pop(0)
    table = np.empty(shape)
    if not ordered:
        table[...] = runs(small, shape)
        return table
    np.multiply(ordered[-1], runs(small, shape), out=table)
    for large in ordered[:-1]:
        table *= runs(large, shape)
    return table


def runs(array: NDArray[np.float64], shape: Sequence[int]) -> NDArray[np.float64]:
    """The array repeated along its last axes, so that a product with it runs over contiguous blocks."""
    target = list(array.shape)
    cells, axis = 1, len(shape)
    while axis and cells < RUN_CELLS:
        axis -= 1
        target[axis] = shape[axis]
        cells *= shape[axis]
    return np.ascontiguousarray(np.broadcast_to(array, target)) if list(array.shape) != target else array
