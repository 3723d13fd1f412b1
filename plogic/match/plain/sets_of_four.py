"""Sets of four features that one viewpoint sees, each with a datum that looks like it, the most distinctive first (§6.3).

* ``every(...)``: all there are; ``drawn(...)``: some, at random, where they are too many
"""

from __future__ import annotations

from itertools import combinations, islice, pairwise, product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from plogic.match.plain.typed_pairs import Typed

    Floats: TypeAlias = NDArray[np.float64]
    Flags: TypeAlias = NDArray[np.bool_]
    Sets: TypeAlias = tuple[NDArray[np.intp], NDArray[np.intp]]

BLOCK = 2000
"""Sets that are handed on at a time."""
DRAWN, POSED = 2000, 1000
"""Sets that are drawn at a time, and those of them, of highest dv, that are handed on."""


def how_many(pairs: Typed) -> int:
    """Sets of four different features, each with a datum that looks like it, whether one viewpoint sees them or not."""
    sums = [1, 0, 0, 0, 0]  # of the products of none, one, ... four of the features' counts so far
    for count in pairs.numbers.tolist():
        sums = [1, *(more + count * fewer for fewer, more in pairwise(sums))]
    return sums[4]


def every(pairs: Typed, seen: Flags, dv: Floats) -> Iterator[Sets]:
    """All sets, as features (N, 4) and different data (N, 4), by their sum of ``dv`` (F,), the greatest first.

    ``seen`` (V, F): what each viewpoint sees.
    """
    count = pairs.numbers
    first = np.cumsum(count) - count
    chosen = np.array(list(combinations(np.flatnonzero(count).tolist(), 4)), np.intp).reshape(-1, 4)
    chosen = chosen[_converging(chosen, seen)]
    chosen = chosen[np.argsort(-dv[chosen].sum(axis=1), kind="stable")]
    rows = (
        (four, data)
        for four in chosen.tolist()
        for data in product(*(pairs.datum[first[f] : first[f] + count[f]].tolist() for f in four))
        if len(set(data)) == 4
    )
    while block := list(islice(rows, BLOCK)):
        yield np.array([four for four, _ in block], np.intp), np.array([data for _, data in block], np.intp)


def _converging(chosen: NDArray[np.intp], seen: Flags) -> Flags:
    """(N,) which of the sets some viewpoint sees whole (*convergence*)."""
    result = np.zeros(len(chosen), bool)
    for view in np.unique(seen, axis=0):
        result |= view[chosen].all(axis=1)
    return result


def drawn(pairs: Typed, seen: Flags, dv: Floats, rng: np.random.Generator) -> Sets:
    """``POSED`` sets of ``DRAWN`` random ones, or fewer: features (N, 4) and different data (N, 4), highest dv first.

    ``seen`` (V, F): what each viewpoint sees; each is drawn as often.
    """
    count = pairs.numbers
    first = np.cumsum(count) - count
    some = seen & (count > 0)
    some = some[some.sum(axis=1) >= 4]
    if not len(some):
        return np.zeros((0, 4), np.intp), np.zeros((0, 4), np.intp)
    lots = np.where(some[rng.integers(len(some), size=DRAWN)], rng.random((DRAWN, len(count))), -1.0)
    feature = np.argpartition(-lots, 3, axis=1)[:, :4]
    datum = pairs.datum[first[feature] + rng.integers(count[feature])]
    ordered = np.sort(datum, axis=1)
    apart = np.flatnonzero((ordered[:, 1:] != ordered[:, :-1]).all(axis=1))
    chosen = apart[np.argsort(-dv[feature[apart]].sum(axis=1), kind="stable")[:POSED]]
    return feature[chosen], datum[chosen]
