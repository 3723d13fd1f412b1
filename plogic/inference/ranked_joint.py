"""The ranking of a small piece: its table of all joint states, sorted."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.inference.merge import Stream

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.inference.parts import Part
    from plogic.inference.ranked_units import Costs, Table

SMALL = 16  # up to so many cells Python sorts faster than numpy
CLAMP = 16  # so many impossible costs are added before they are brought back to one


class Digits(NamedTuple):
    """How solutions are written: what a state of each variable of the piece adds, and by how many bits costs are shifted."""

    places: Sequence[int]
    shift: int

    def code(self, number: int, cards: Sequence[int]) -> int:
        """The states of all variables whose joint state has this number, the last fastest."""
        code = 0
        for place, card in zip(reversed(self.places), reversed(cards), strict=True):
            number, state = divmod(number, card)
            code += state * place
        return code


class Joint(Stream):
    """The cells of a table in order, ties lexicographic; the impossible ones come last, and end it."""

    __slots__ = ("_cards", "_costs", "_digits", "_impossible", "_order")

    def __init__(self, table: Table, cards: Sequence[int], digits: Digits, impossible: int) -> None:
        super().__init__()
        self._cards, self._digits, self._impossible = cards, digits, impossible
        self._order, self._costs = ordered(table.reshape(-1))

    def advance(self) -> None:
        """Take the next cell."""
        rank = len(self.found)
        if rank == len(self._order) or self._costs[cell := self._order[rank]] >= self._impossible:
            self.done = True
        else:
            self.found.append((self._costs[cell] << self._digits.shift) + self._digits.code(cell, self._cards))


def ordered(costs: Table) -> tuple[list[int], list[int]]:
    """(the numbers of the cells, least cost first, ties by number; all costs)."""
    values = costs.tolist()
    if len(values) <= SMALL or costs.dtype == object:
        return sorted(range(len(values)), key=values.__getitem__), values
    return costs.argsort(kind="stable").tolist(), values


def joint(part: Part, costs: Costs, digits: Digits) -> Stream:
    """The solutions of a piece, by the table of all its joint states."""
    cards = part.cards
    terms = []
    for (scope, _), table in zip(part.tables, costs.tables, strict=True):
        shape = [1] * len(cards)
        for v in scope:
            shape[v] = cards[v]
        terms.append(table.reshape(shape))
    return Joint(total(terms, cards, costs.impossible), cards, digits, costs.impossible)


def total(terms: Sequence[Table], shape: Sequence[int], impossible: int) -> Table:
    """The sum of tables that have one axis a variable, of full length or of length 1; ``impossible`` or more is impossible."""
    result = np.zeros(shape, dtype=terms[0].dtype if terms else np.int64)
    for i, table in enumerate(terms, 1):
        result += table
        if i % CLAMP == 0:
            np.minimum(result, impossible, out=result)
    return result
