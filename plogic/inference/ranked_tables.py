"""Sums of cost tables, and their cells in order, as few of them as are asked for."""

from __future__ import annotations

import functools
import math
import operator
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.inference.messages import BLOCK, FEW, runs

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from plogic.inference.ranked_units import Table

_CELLS = attrgetter("size")
CLAMP = 16  # so many impossible costs are added before they are brought back to one
SMALL = 64  # cells up to which the least is looked for one at a time; of more, several
FIRST = 16  # so many at first
LARGE = 2 * BLOCK  # cells


class Cells:
    """The cells of a table, least cost first, ties by number: ``numbers`` and ``costs`` of those found so far; never an impossible one."""

    __slots__ = ("_bound", "_flat", "_impossible", "_values", "costs", "numbers")

    def __init__(self, table: Table, impossible: float) -> None:
        self.numbers: list[int] = []
        self.costs: list[Any] = []  # as the table has them
        self._impossible = impossible
        self._bound = -math.inf  # of a large table all cells of no greater cost are found
        flat = table.ravel()
        small = len(flat) <= SMALL or flat.dtype == object
        self._values: list[Any] = flat.tolist() if small else []
        self._flat: Table | None = None if small else flat

    def reach(self, rank: int) -> bool:
        """Find the cell of a rank; whether there is one."""
        costs = self.costs
        while len(costs) <= rank:
            if self._flat is not None:
                self._several(self._flat)
            elif not self._values or (cost := min(self._values)) >= self._impossible:
                return False
            else:
                costs.append(cost)
                self.numbers.append(number := self._values.index(cost))
                self._values[number] = self._impossible
        return True

    def _several(self, flat: Table) -> None:
        """About four times as many cells as before."""
        wanted = FIRST + 4 * len(self.costs)
        bound = np.partition(flat, wanted)[wanted] if wanted < len(flat) else self._impossible
        last = bool(bound >= self._impossible)
        chosen = ((flat < self._impossible if last else flat <= bound) & (flat > self._bound)).nonzero()[0]
        costs = flat[chosen]
        order = costs.argsort(kind="stable")
        self.numbers += chosen[order].tolist()
        self.costs += costs[order].tolist()
        self._bound = bound
        if last:
            self._flat = None


def total(terms: Sequence[Table], shape: Sequence[int], impossible: float) -> Table:
    """The sum of tables, each over the last axes of ``shape``, of full length or of length 1; ``impossible`` or more is impossible.

    The order is such that few of the sums on the way have all cells.
    """
    if not terms:
        return np.zeros(shape, dtype=np.int64)
    if len(terms) <= CLAMP and math.prod(shape) < LARGE:
        result = functools.reduce(operator.add, terms)
    else:
        result, *others = sorted(terms, key=_CELLS)
        for i, table in enumerate(others, 1):
            result = _sum(result, table, shape)
            if i % CLAMP == 0:
                np.minimum(result, impossible, out=result)
    return result if result.shape == tuple(shape) else _sum(np.zeros(shape, dtype=result.dtype), result, shape)


def _sum(one: Table, other: Table, shape: Sequence[int]) -> Table:
    """Added up in contiguous runs, if they are large."""
    if one.size < LARGE and other.size < LARGE:
        return np.asarray(one + other)
    return runs(one, shape[len(shape) - one.ndim :]) + runs(other, shape[len(shape) - other.ndim :])


def placed(scope: Sequence[int], flat: Table, place: Mapping[int, int], cards: Sequence[int]) -> Table:
    """A flat table over ``scope`` with as many axes as ``place``, each variable's where it says; length 1 elsewhere, none before the first."""
    if len(scope) == 1:
        return flat.reshape((-1,) + (1,) * (len(place) - 1 - place[scope[0]]))
    places = [place[v] for v in scope]
    shape = [1] * len(place)
    for axis, v in zip(places, scope):  # noqa: B905 - as many; this is run for every table of a scene
        shape[axis] = cards[v]
    inner = sorted(places)
    if places != inner:
        flat = flat.reshape([cards[v] for v in scope]).transpose(sorted(range(len(scope)), key=places.__getitem__))
    return flat.reshape(shape[inner[0] :] if inner else shape)


def least(table: Table) -> Table:
    """The least of each row; of few columns one by one, where numpy would start anew for every short row."""
    rows, columns = table.shape
    if columns > FEW or rows < BLOCK:
        return np.asarray(np.minimum.reduce(np.ascontiguousarray(table.T)))
    result = table[:, 0].copy()
    for column in range(1, columns):
        np.minimum(result, table[:, column], out=result)
    return result
