"""The ranking of a small piece: the cells of its table of all joint states, in order."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.inference.merge import Stream
from plogic.inference.ranked_tables import Cells, total

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.inference.parts import Part
    from plogic.inference.ranked_units import Costs, Table


class Digits(NamedTuple):
    """How solutions are written: what a state of each variable of the piece adds, and by how many bits costs are shifted."""

    places: Sequence[int]
    shift: int


class Coder:
    """The digits of some variables, all states of which are numbered jointly, the last fastest."""

    __slots__ = ("_cards", "_places", "shift")

    def __init__(self, places: Sequence[int], cards: Sequence[int], shift: int) -> None:
        self._places, self._cards, self.shift = places, cards, shift

    def code(self, number: int) -> int:
        """The states that have this number."""
        code = 0
        for card, place in zip(reversed(self._cards), reversed(self._places), strict=True):
            number, state = divmod(number, card)
            code += state * place
        return code


class Joint(Stream):
    """The possible cells of a table in order, ties lexicographic."""

    __slots__ = ("_cells", "_coder")

    def __init__(self, table: Table, coder: Coder, impossible: int) -> None:
        super().__init__()
        self._cells, self._coder = Cells(table, impossible), coder

    def advance(self) -> None:
        """Take the next cell."""
        cells, rank = self._cells, len(self.found)
        if cells.reach(rank):
            self.found.append((cells.costs[rank] << self._coder.shift) + self._coder.code(cells.numbers[rank]))
        else:
            self.done = True


def joint(part: Part, costs: Costs, digits: Digits) -> Stream:
    """The solutions of a piece, by the table of all its joint states."""
    cards = part.cards
    last = len(cards) - 1
    terms = []
    for (scope, _), table in zip(part.tables, costs.tables):  # noqa: B905 - as many; this is run for every table of a scene
        first = scope[0]  # the axes before are left to broadcasting
        shape = [1] * (last - first + 1)
        for v in scope:
            shape[v - first] = cards[v]
        terms.append(table if first == last else table.reshape(shape))
    return Joint(total(terms, cards, costs.impossible), Coder(digits.places, cards, digits.shift), costs.impossible)
