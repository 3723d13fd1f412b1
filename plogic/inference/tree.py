"""A tree of buckets: which variables are summed out together, over which table, and whom the sum is told.

Bucket elimination, one bucket a variable (R. Dechter 1999), as a tree that is passed twice (S. Lauritzen and D.
Spiegelhalter 1988). Small neighbouring buckets are merged into one: a table of a thousand cells costs numpy no more
than one of ten.

* ``Bucket((7, 3, 5), 2, 4, (0, 6), (1,))``: a table over the variables 7, 3, 5, in this order of axes; the first 2 (the
  separator) are shared with the parent, bucket 4, the others (the residual) are in no later bucket; tables 0 and 6 and
  the message of bucket 1 enter it
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from plogic.inference.order import members

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.inference.order import Order

CELLS = 1 << 10  # buckets are merged up to this many cells


class Bucket(NamedTuple):
    """``scope``: axes by their turn in the order, latest first; ``parent`` is −1 for a root; buckets are listed children first."""

    scope: tuple[int, ...]
    shared: int
    parent: int
    tables: tuple[int, ...]
    children: tuple[int, ...]


def bucket_tree(cards: Sequence[int], scopes: Sequence[tuple[int, ...]], order: Order) -> tuple[Bucket, ...]:
    """The buckets of all variables in the order; each scope (no empty one) is told to the bucket of its first variable."""
    turn = {v: i for i, v in enumerate(order.sequence)}
    parents, home, residuals = _merged(cards, order, turn)
    number = {v: i for i, v in enumerate(residuals)}
    tables: list[list[int]] = [[] for _ in residuals]
    for i, scope in enumerate(scopes):
        tables[number[home[min(scope, key=turn.__getitem__)]]].append(i)
    children: list[list[int]] = [[] for _ in residuals]
    for v, parent in parents.items():
        if parent >= 0:
            children[number[parent]].append(number[v])
    result = []
    for v, residual in residuals.items():
        shared = sorted(members(order.rests[v]), key=turn.__getitem__, reverse=True)
        scope = (*shared, *sorted(residual, key=turn.__getitem__, reverse=True))
        parent = number[parents[v]] if parents[v] >= 0 else -1
        result.append(Bucket(scope, len(shared), parent, tuple(tables[number[v]]), tuple(children[number[v]])))
    return tuple(result)


def _merged(
    cards: Sequence[int], order: Order, turn: dict[int, int]
) -> tuple[dict[int, int], dict[int, int], dict[int, list[int]]]:
    """(parent of each bucket that stays, bucket of every variable, residual of each bucket that stays), a bucket named by its last variable."""
    parents = {v: min(members(order.rests[v]), key=turn.__getitem__, default=-1) for v in order.sequence}
    residuals = {v: [v] for v in order.sequence}
    cells = {}
    for v in order.sequence:
        cells[v] = cards[v]
        for u in members(order.rests[v]):
            cells[v] *= cards[u]
    for v in order.sequence:
        parent = parents[v]
        if parent < 0:
            continue
        size = cells[parent]
        for u in residuals[v]:
            size *= cards[u]
        if size <= max(CELLS, cells[v]):
            residuals[parent] += residuals.pop(v)
            cells[parent] = size
    home = {u: v for v, residual in residuals.items() for u in residual}
    return {v: home[parents[v]] if parents[v] >= 0 else -1 for v in residuals}, home, residuals
