"""Tables over variables, with their axes put where another table has them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    Scoped = tuple[tuple[int, ...], NDArray[np.float64]]

Term = TypeVar("Term", bound="tuple[tuple[int, ...], NDArray[Any]]")


def aligned(scope: Sequence[int], table: NDArray[np.float64], place: Mapping[int, int]) -> NDArray[np.float64]:
    """A view of the table (axes by ``scope``) with as many axes as ``place``: each variable's where it says, length 1 elsewhere."""
    places = [place[v] for v in scope]
    shape = [1] * len(place)
    for axis, length in zip(places, table.shape, strict=True):
        shape[axis] = length
    if places != sorted(places):
        table = table.transpose(sorted(range(len(scope)), key=places.__getitem__))
    return table.reshape(shape)


def product(tables: Iterable[Scoped], scope: Sequence[int], cards: Sequence[int]) -> NDArray[np.float64]:
    """The sum of log tables, over ``scope``, one axis a variable."""
    place = {v: axis for axis, v in enumerate(scope)}
    result = np.zeros([cards[v] for v in scope])
    for own, table in tables:
        result += aligned(own, table, place)
    return result


def log_sum(table: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """(greatest, logarithms of the sums over the last axis, less the greatest); (−inf, zeros) if all is impossible."""
    rows = table.reshape(-1, table.shape[-1])
    tops = rows.max(axis=1)
    if tops.max() == -np.inf:
        return -np.inf, np.zeros(table.shape[:-1])
    tops[tops == -np.inf] = 0.0
    with np.errstate(divide="ignore"):
        sums = np.log(np.exp(rows - tops[:, None]).sum(axis=1)) + tops
    top = float(sums.max())
    return top, (sums - top).reshape(table.shape[:-1])


def sliced(scope: Sequence[int], table: NDArray[np.float64], fixed: Mapping[int, int]) -> Scoped:
    """The table where the ``fixed`` variables have their states, over the others."""
    index = tuple([fixed.get(v, slice(None)) for v in scope])
    return tuple([v for v in scope if v not in fixed]), np.asarray(table[index])


def in_groups(terms: Sequence[Term], cards: Sequence[int], bits: float) -> list[list[Term]]:
    """The tables in groups whose joint table has at most so many bits, the largest first, each to the first group that has room."""
    groups: list[tuple[set[int], list[Term]]] = []
    for term in sorted(terms, key=lambda one: -one[1].size):
        for union, group in groups:
            if sum(math.log2(cards[v]) for v in union.union(term[0])) <= bits:
                union.update(term[0])
                group.append(term)
                break
        else:
            groups.append((set(term[0]), [term]))
    return [group for _, group in groups]
