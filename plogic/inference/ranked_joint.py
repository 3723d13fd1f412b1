"""The ranking of a small piece: the cells of its table of all joint states, in order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from plogic.inference.merge import Stream
from plogic.inference.ranked_tables import Cells, total
from plogic.inference.ranked_units import in_units

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.inference.parts import Part
    from plogic.inference.ranked_units import Table


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
    last = len(cards) - 1
    terms = []
    for scope, table in part.tables:
        first = scope[0]  # the axes before are left to broadcasting
        shape = [1] * (last - first + 1)
        for v in scope:
            shape[v - first] = cards[v]
        terms.append(table if first == last else table.reshape(shape))
    return Joint(-total(terms, cards, math.inf), Coder(digits.places, cards, digits.shift), math.inf, in_units)
