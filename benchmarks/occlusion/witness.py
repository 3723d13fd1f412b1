"""Three connected bodies for a triple of occlusion relations: what bounds the composition table from below (§3.7).

An *arrangement* is three connected sets of squares on the image. Over it any nonempty set of depth orders in each cell
can be built by bodies
that are connected and share no volume: every square is cut into 5 x 3 small ones with 8 layers. The layers 0, 1, 2 hold
    the bodies of the
square in its order, the layers 3, 4, 5 hold x, y and z again, one layer each over the whole of a body's image: there
each body is one. Three
small squares in the middle lead from the front to the back, one for each body::

      the first's column      the second's      the third's        everywhere else
      first    0 .. back      0                 0                  0, back
      second   6              1 .. 6            1                  1, back
      third    7              7                 2 .. 7             2, back

So no depth order is out of reach, and what is left to find are arrangements.
"""

from __future__ import annotations

from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.occlusion.stacks import boxes, codes, masks_of, one_piece
from geometry.visibility.composition import PAIRS, Images, possible_fronts, rcc_terms, triple_of
from geometry.visibility.roc import ROC20, parts_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from benchmarks.occlusion.stacks import Grids
    from geometry.visibility.composition import Cell, Contact, Fronts, Terms, Triple

WIDE, HIGH, DEEP = 5, 3, 8
"""Small squares of a square, across and down, and layers."""
FINER = 3
"""Squares that one of an arrangement is cut into, each way: so that the smallest cell has room for all six orders."""


class Arrangement(NamedTuple):
    """``squares`` (3, U, V), connected each; the cells there are; and the RCC-8 terms of (x, y), (y, z), (x, z)."""

    squares: NDArray[np.bool_]
    cells: frozenset[Cell]
    terms: Terms


def arrangements(rng: np.random.Generator, count: int, side: int = 7) -> list[Arrangement]:
    """Of ``count`` random ones and all their renamings, one for each set of cells with its terms."""
    found: dict[tuple[frozenset[Cell], Terms], Arrangement] = {}
    for squares in (*masks_of(rng, count, 3, side), *_framed(rng, count // 10, side)):
        if not all(one_piece(image) for image in squares):
            continue
        for order in permutations(range(3)):
            one = arranged(squares[list(order)])
            found.setdefault((one.cells, one.terms), one)
    return list(found.values())


def _framed(rng: np.random.Generator, count: int, side: int) -> NDArray[np.bool_]:
    """(count, 3, side, side) a box of all squares, and two in it.

    What lies deep in another is rare among random ones.
    """
    squares = boxes(rng, 3 * count, side).reshape(count, 3, side, side)
    squares[:, 0] = True
    return squares


def arranged(squares: NDArray[np.bool_]) -> Arrangement:
    """The arrangement of three images (3, U, V); the border of the grid is kept free, so that nothing is cut off."""
    framed = np.pad(squares, ((0, 0), (1, 1), (1, 1)))
    cells = frozenset(_as_cell(row) for row in np.unique(framed.reshape(3, -1), axis=1).T.tolist() if any(row))
    return Arrangement(framed, cells, rcc_terms(Images(cells, _contacts(framed))))


def _as_cell(row: list[bool]) -> Cell:
    return row[0], row[1], row[2]


def _contacts(squares: NDArray[np.bool_]) -> frozenset[Contact]:
    """A contact of each pair whose boundaries meet, which is all that the terms ask."""
    edges = [_corners_of_boundary(image) for image in squares]
    return frozenset(_contact(pair) for pair in PAIRS if (edges[pair[0]] & edges[pair[1]]).any())


def _contact(pair: tuple[int, int]) -> Contact:
    first, second, third = (None if i in pair else False for i in range(3))
    return first, second, third


def _corners_of_boundary(image: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(U - 1, V - 1) the corners between squares at which some are in the image and some are not."""
    around = np.stack([image[:-1, :-1], image[1:, :-1], image[:-1, 1:], image[1:, 1:]])
    return np.asarray(around.any(axis=0) & ~around.all(axis=0))


def triples(found: Iterable[Arrangement]) -> frozenset[Triple]:
    """What can be built over the arrangements."""
    pairs = {(one.cells, one.terms) for one in found}
    return frozenset(triple_of(terms, fronts) for cells, terms in pairs for fronts in possible_fronts(cells))


def checked(found: Iterable[Arrangement], some: Iterable[Triple], rng: np.random.Generator, count: int) -> list[bool]:
    """For ``count`` of the triples, drawn at random.

    Whether the bodies built for it are one piece each and stand in its relations.
    """
    by_terms: dict[Terms, list[Arrangement]] = {}
    for one in found:
        by_terms.setdefault(one.terms, []).append(one)
    ordered = sorted(some)
    return [_holds(ordered[i], by_terms) for i in rng.permutation(len(ordered))[:count].tolist()]


def _holds(triple: Triple, by_terms: Mapping[Terms, list[Arrangement]]) -> bool:
    (a, first), (b, second), (c, third) = (parts_of(relation) for relation in triple)
    one = next(one for one in by_terms[a, b, c] if (first, second, third) in possible_fronts(one.cells))
    grid = built(one, triple)
    relations = tuple(ROC20[int(codes(grid, x + 1, y + 1)[0])] for x, y in PAIRS)
    return relations == triple and all(one_piece(grid[0] == body) for body in (1, 2, 3))


def built(one: Arrangement, triple: Triple) -> Grids:
    """The bodies 1, 2, 3 in the relations of the ``triple``, one grid (1, U, V, 8), over an arrangement with its terms.

    In each cell all the orders occur that do not contradict the triple: where some choice of orders builds it, this one
    does.
    """
    squares = one.squares.repeat(FINER, axis=1).repeat(FINER, axis=2)
    first, second, third = (parts_of(relation)[1] for relation in triple)
    allowed = _allowed((first, second, third))
    grid = np.zeros((squares.shape[1] * WIDE, squares.shape[2] * HIGH, DEEP), dtype=np.int8)
    count: dict[tuple[int, ...], int] = {}
    for i, j in np.argwhere(squares.any(axis=0)).tolist():
        members = tuple(np.flatnonzero(squares[:, i, j]).tolist())
        orders = [
            order
            for order in permutations(members)
            if all(_keeps(order, pair, sides) for pair, sides in allowed.items())
        ]
        turn = count[members] = count.get(members, -1) + 1
        if orders:
            grid[i * WIDE : (i + 1) * WIDE, j * HIGH : (j + 1) * HIGH] = _block(orders[turn % len(orders)])
    return grid[None]


def _allowed(fronts: Fronts) -> dict[tuple[int, int], str]:
    return {pair: {"x": "x", "y": "y"}.get(front, "xy") for pair, front in zip(PAIRS, fronts, strict=True)}


def _keeps(order: tuple[int, ...], pair: tuple[int, int], sides: str) -> bool:
    if not set(pair) <= set(order):
        return True
    return ("x" if order.index(pair[0]) < order.index(pair[1]) else "y") in sides


def _block(order: tuple[int, ...]) -> NDArray[np.int8]:
    """(5, 3, 8) one square with its bodies in this order from the front, as drawn above."""
    block = np.zeros((WIDE, HIGH, DEEP), dtype=np.int8)
    for place, body in enumerate(order):
        block[:, :, place] = block[:, :, 3 + body] = body + 1
    for column in range(len(order)):
        stack = np.zeros(DEEP, dtype=np.int8)
        for place, body in enumerate(order):
            if place < column:
                stack[place] = body + 1
            elif place > column:
                stack[5 + place] = body + 1
        ends = 3 + order[column] if column == 0 else 5 + column
        stack[column : ends + 1] = order[column] + 1
        block[1 + column, 1] = stack
    return block
