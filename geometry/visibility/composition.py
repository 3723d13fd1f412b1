"""Which triples R(x, y), S(y, z), T(x, z) of occlusion relations there can be at all: every abstract model, enumerated.

An abstract model of three images says which *cells* there are (a cell: in x or not, in y or not, in z or not, having an
interior), which *contacts* (a point on the boundary of two or three of the images, and inside, outside or on the
boundary of the third), and for every cell in two or more images the nonempty set of depth orders that occur in it. Any
three bodies without coincident surfaces have one: near a contact there are cells on both sides of each boundary that it
lies on, and along a ray that meets several bodies one is first, one second. So what no model has, no bodies have: the
triples of all models bound the composition table from above (§3.7).

``Triple``: ``("partially_occludes_po", "totally_occludes_ntppi", "partially_occludes_po")``, of (x, y), (y, z), (x, z).
"""

from __future__ import annotations

from functools import cache
from itertools import combinations, permutations, product
from typing import TYPE_CHECKING, NamedTuple

from geometry.visibility.roc import Front, Rcc8, Roc, roc

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


Cell = tuple[bool, bool, bool]
"""In x, in y, in z."""
Contact = tuple[bool | None, bool | None, bool | None]
"""Inside (True), outside (False) or on the boundary (None) of each."""
Triple = tuple[Roc, Roc, Roc]
Fronts = tuple[Front, Front, Front]
Terms = tuple[Rcc8, Rcc8, Rcc8]
Firsts = tuple[frozenset[int], frozenset[int], frozenset[int]]
"""Of each pair, which of its two (0, 1) is first somewhere."""

PAIRS = ((0, 1), (1, 2), (0, 2))
CELLS: tuple[Cell, ...] = tuple((x, y, z) for x, y, z in product((False, True), repeat=3) if x or y or z)
CONTACTS: tuple[Contact, ...] = tuple(
    (x, y, z) for x, y, z in product((False, True, None), repeat=3) if (x, y, z).count(None) >= 2
)
_OUTSIDE: Cell = (False, False, False)


class Images(NamedTuple):
    """The cells that there are, the one outside of all aside, and the contacts."""

    cells: frozenset[Cell]
    contacts: frozenset[Contact]


@cache
def possible_triples() -> frozenset[Triple]:
    """The triples of all models."""
    found: set[Triple] = set()
    for cells in _cell_sets():
        fronts = possible_fronts(cells)
        for terms in {rcc_terms(images) for images in _with_contacts(cells)}:
            found.update(triple_of(terms, some) for some in fronts)
    return frozenset(found)


def triple_of(terms: Terms, fronts: Fronts) -> Triple:
    """The relations of (x, y), (y, z), (x, z) from how their images lie and who is in front."""
    return roc(terms[0], fronts[0]), roc(terms[1], fronts[1]), roc(terms[2], fronts[2])


def _cell_sets() -> Iterator[frozenset[Cell]]:
    """Every set of cells in which each of the three has an image."""
    for size in range(1, len(CELLS) + 1):
        yield from (
            frozenset(some)
            for some in combinations(CELLS, size)
            if all(any(cell[i] for cell in some) for i in range(3))
        )


def _with_contacts(cells: frozenset[Cell]) -> Iterator[Images]:
    """The images with every set of contacts that these cells leave room for."""
    able = [contact for contact in CONTACTS if _has_room(contact, cells)]
    for size in range(len(able) + 1):
        yield from (Images(cells, frozenset(some)) for some in combinations(able, size))


def _has_room(contact: Contact, cells: frozenset[Cell]) -> bool:
    """Whether some cells that may meet at the contact lie on both sides of every boundary through it."""
    around = [
        cell
        for cell in (*cells, _OUTSIDE)
        if all(side is None or side == inside for side, inside in zip(contact, cell, strict=True))
    ]
    return all(len({cell[i] for cell in around}) == 2 for i in range(3) if contact[i] is None)


def rcc_terms(images: Images) -> Terms:
    """The RCC-8 relations of (x, y), (y, z), (x, z)."""
    return _rcc(images, 0, 1), _rcc(images, 1, 2), _rcc(images, 0, 2)


def _rcc(images: Images, i: int, j: int) -> Rcc8:
    touching = any(contact[i] is None and contact[j] is None for contact in images.contacts)
    both, i_alone, j_alone = (
        any((cell[i], cell[j]) == where for cell in images.cells)
        for where in ((True, True), (True, False), (False, True))
    )
    if not both:
        return "EC" if touching else "DC"
    if i_alone and j_alone:
        return "PO"
    if not i_alone and not j_alone:
        return "EQ"
    if i_alone:
        return "TPPi" if touching else "NTPPi"
    return "TPP" if touching else "NTPP"


@cache
def possible_fronts(cells: frozenset[Cell]) -> frozenset[Fronts]:
    """Who is in front of (x, y), (y, z), (x, z), for every choice of a nonempty set of depth orders in each cell."""
    nobody: frozenset[int] = frozenset()
    found: set[Firsts] = {(nobody, nobody, nobody)}
    for cell in cells:
        choices = _order_sets(tuple(i for i in range(3) if cell[i]))
        found = {(a | p, b | q, c | r) for a, b, c in found for p, q, r in choices}
    return frozenset((_front(a), _front(b), _front(c)) for a, b, c in found)


@cache
def _order_sets(members: tuple[int, ...]) -> frozenset[Firsts]:
    """For every nonempty set of orders of the members: per pair, which of its two is before the other in some order."""
    orders = list(permutations(members))
    sets = (some for size in range(1, len(orders) + 1) for some in combinations(orders, size))
    return frozenset(_firsts(some) for some in sets)


def _firsts(orders: Sequence[tuple[int, ...]]) -> Firsts:
    return _first_of((0, 1), orders), _first_of((1, 2), orders), _first_of((0, 2), orders)


def _first_of(pair: tuple[int, int], orders: Sequence[tuple[int, ...]]) -> frozenset[int]:
    return frozenset(pair.index(min(pair, key=order.index)) for order in orders if set(pair) <= set(order))


def _front(first: frozenset[int]) -> Front:
    if len(first) == 2:
        return "both"
    return "nobody" if not first else "y" if 1 in first else "x"
