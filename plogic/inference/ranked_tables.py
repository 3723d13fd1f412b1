"""Log weights as whole numbers of units; sums of such costs, and their cells in order, as few of them as are asked for.

Sums of floating-point numbers depend on their order: a bound and the weight that it bounds then differ by noise, and
ties come out at random. Here a table becomes *costs*: how many units of ``2^−42`` (2.3e-13) its entries lie below its
greatest entry, rounded once per entry; all later sums are exact. Only the tables of one small piece or bucket are
summed before that, in doubles: noise far below a tie (``ranked``). A table with a range so wide that its piece's costs
would not fit in 64 bits keeps fewer digits, down to ``2^−36`` (1.5e-11), and past that is in Python's own integers, of
any size.

* ``Costs(-1.3, [array([0, 7]), ...], 2**58, 0)``: the greatest entries' sum; costs ≥ 0 by table, in units of
  ``2^−42 << shift``; the cost that stands for impossible
* ``Joint``: the ranking of a small piece, by the cells of its table of all joint states, in order
"""

import functools
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate, pairwise
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plogic.inference.graph import Part
from plogic.inference.merge import Stream
from plogic.inference.passes import FEW_COLUMNS, RUN_CELLS, runs

Table = NDArray[Any]  # int64, or Python's integers as objects

_CELLS = attrgetter("size")
DIGITS = 42  # binary digits behind the point
FEWEST_DIGITS = 36  # digits that 64-bit costs keep at least
COST_BITS = 57  # every possible cost of a piece is below 2^57
IMPOSSIBLE = 1 << (COST_BITS + 1)  # so that 31 of them still fit in 64 bits


class Costs(NamedTuple):
    """A piece's tables as costs, in their order, flattened, below ``top``.

    Sums of ``impossible`` and more are impossible.
    """

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
    if ((below >= 2.0 ** (COST_BITS - DIGITS) / len(tables)) & (below < np.inf)).any():
        units, impossible, shift = _scaled(below, greatest, flat, cuts)
    else:
        np.minimum(below, 2.0 ** (COST_BITS + 1 - DIGITS), out=below)
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
    span = sum(np.maximum.reduceat(np.where(below < np.inf, below, 0.0), cuts[:-1]).tolist())
    digits = DIGITS if span < 2.0 ** (COST_BITS - DIGITS) else COST_BITS - 1 - math.ceil(math.log2(span))
    if digits >= FEWEST_DIGITS:
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


SUMS_AT_ONCE = 16  # so many impossible costs are added before they are brought back to one
SMALL_TABLE = 64  # cells up to which the least is looked for one at a time; of more, several
FIRST_CELLS = 16  # so many at first
LARGE_TABLE = 2 * RUN_CELLS  # cells


class Cells:
    """The cells of a table, least cost first, ties by number: ``numbers`` and ``costs`` of those found so far.

    Never an impossible one.
    """

    __slots__ = ("_bound", "_flat", "_impossible", "_values", "costs", "numbers")

    def __init__(self, table: Table, impossible: float) -> None:
        self.numbers: list[int] = []
        self.costs: list[Any] = []  # as the table has them
        self._impossible = impossible
        self._bound = -math.inf  # of a large table all cells of no greater cost are found
        flat = table.ravel()
        small = len(flat) <= SMALL_TABLE or flat.dtype == object
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
        wanted = FIRST_CELLS + 4 * len(self.costs)
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
    """The sum of tables, each over the last axes of ``shape``, of full length or of length 1.

    ``impossible`` or more is impossible.

    The order is such that few of the sums on the way have all cells.
    """
    if not terms:
        return np.zeros(shape, dtype=np.int64)
    if len(terms) <= SUMS_AT_ONCE and math.prod(shape) < LARGE_TABLE:
        result = functools.reduce(operator.add, terms)
    else:
        result, *others = sorted(terms, key=_CELLS)
        for i, table in enumerate(others, 1):
            result = _sum(result, table, shape)
            if i % SUMS_AT_ONCE == 0:
                np.minimum(result, impossible, out=result)
    return result if result.shape == tuple(shape) else _sum(np.zeros(shape, dtype=result.dtype), result, shape)


def _sum(one: Table, other: Table, shape: Sequence[int]) -> Table:
    """Added up in contiguous runs, if they are large."""
    if one.size < LARGE_TABLE and other.size < LARGE_TABLE:
        return np.asarray(one + other)
    return runs(one, shape[len(shape) - one.ndim :]) + runs(other, shape[len(shape) - other.ndim :])


def placed(scope: Sequence[int], flat: Table, place: Mapping[int, int], cards: Sequence[int]) -> Table:
    """A flat table over ``scope`` with as many axes as ``place``, each variable's where it says.

    Length 1 elsewhere, none before the first.
    """
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
    if columns > FEW_COLUMNS or rows < RUN_CELLS:
        return np.asarray(np.minimum.reduce(np.ascontiguousarray(table.T)))
    result = table[:, 0].copy()
    for column in range(1, columns):
        np.minimum(result, table[:, column], out=result)
    return result


class Digits(NamedTuple):
    """How solutions are written: what a state of each variable of the piece adds, and by how many bits costs are shifted."""

    places: Sequence[int]
    shift: int


class Coder:
    """The digits of some variables, all states of which are numbered jointly, the last fastest."""

    __slots__ = ("_cards", "_known", "_places", "shift")

    def __init__(self, places: Sequence[int], cards: Sequence[int], shift: int) -> None:
        self._places, self._cards, self.shift = places, cards, shift
        self._known: dict[int, int] = {}

    def code(self, number: int) -> int:
        """The states that have this number."""
        code = self._known.get(number)
        if code is None:
            code, rest = 0, number
            for card, place in zip(reversed(self._cards), reversed(self._places), strict=True):
                rest, state = divmod(rest, card)
                code += state * place
            self._known[number] = code
        return code


class Joint(Stream):
    """The possible cells of a table of costs in order, ties lexicographic; ``units`` turns a cost into units."""

    __slots__ = ("_cells", "_coder", "_units")

    def __init__(self, table: Table, coder: Coder, impossible: float, units: Callable[[Any], int] = int) -> None:
        super().__init__()
        self._cells, self._coder, self._units = Cells(table, impossible), coder, units

    def advance(self) -> None:
        """Take the next cell."""
        cells, coder, rank = self._cells, self._coder, len(self.found)
        if cells.reach(rank):
            self.found.append((self._units(cells.costs[rank]) << coder.shift) + coder.code(cells.numbers[rank]))
        else:
            self.done = True


def joint(part: Part, digits: Digits) -> Stream:
    """The solutions of a small piece, by the table of all its joint states."""
    cards = part.cards
    place = {v: v for v in range(len(cards))}
    terms = [placed(*table, place, cards) for table in part.tables]
    return Joint(-total(terms, cards, math.inf), Coder(digits.places, cards, digits.shift), math.inf, in_units)
