"""Elimination orders (min-fill, and sweeps where min-fill leaves large tables), and the tree of buckets of an order.

The order decides the largest table of bucket elimination (R. Dechter, Bucket elimination: a unifying framework for
reasoning, 1999); the best order is NP-hard to find, and min-fill (least new edges first) is the usual heuristic (U.
Kjærulff, 1990). On grids a sweep is better: it eliminates from one end, always the variable that makes the boundary
grow least. All orders are deterministic.

A tree of buckets says which variables are summed out together, over which table, and which bucket gets the sum: bucket
elimination, one bucket a variable (R. Dechter 1999), as a tree that is passed twice (S. Lauritzen and D. Spiegelhalter
1988). Small neighbouring buckets are merged into one: a table of a thousand cells costs numpy no more
than one of ten.

* ``Order((2, 0, 1), ({0, 1}, {1}, ...), 3.0, 3.8)``: the variables as they go; per variable, the ones still there that
  its table then has (as bits of an integer); the width and the work in bits
* ``Bucket((7, 3, 5), 2, 4, (0, 6), (1,))``: a table over the variables 7, 3, 5, in this order of axes; the first 2 (the
  separator) are shared with the parent, bucket 4, the others (the residual) are in no later bucket; tables 0 and 6 and
  the message of bucket 1 enter it
"""

import heapq
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import NamedTuple

from plogic.base.errors import WidthError

MOST_BITS = 1000.0  # of a limit: no double holds more cells
EASY = 12.0  # bits; up to here min-fill's order is taken as it is


@dataclass(frozen=True)
class Order:
    """``sequence`` of all variables; ``rests[v]``: bits of v's neighbours at its turn.

    ``width``, ``work``: log2 of the largest, of all tables.
    """

    sequence: tuple[int, ...]
    rests: tuple[int, ...]
    width: float
    work: float


def neighbours(count: int, scopes: Iterable[Sequence[int]]) -> list[int]:
    """Per variable, the variables that share a scope with it, as bits of an integer (never itself)."""
    result = [0] * count
    for scope in scopes:
        mask = sum([1 << v for v in scope])
        for v in scope:
            result[v] |= mask
    return [mask & ~(1 << v) for v, mask in enumerate(result)]


def elimination_order(
    cards: Sequence[int],
    scopes: Iterable[Sequence[int]],
    check: Callable[[], None] = lambda: None,
    most: float = math.inf,
) -> Order:
    """The best order found: min-fill's, and past ``EASY`` bits the cheapest of min-fill, a sweep and the numbering.

    ``check`` is called at every variable, and may raise. WidthError where min-fill comes to a table of more than
    2^``most`` cells.
    """
    bits = [math.log2(card) for card in cards]
    graph = neighbours(len(cards), scopes)
    best = _order(min_fill(list(graph), cards, range(len(cards)), check, most), bits)
    if best.width <= EASY:
        return best
    others = (_along(graph, bits, sweep(graph, bits, check)), _along(graph, bits, range(len(cards))))
    return min((best, *others), key=lambda order: order.work)


def order_along(cards: Sequence[int], scopes: Iterable[Sequence[int]], sequence: Sequence[int]) -> Order:
    """What eliminating in the given sequence leads to."""
    return _along(neighbours(len(cards), scopes), [math.log2(card) for card in cards], sequence)


def min_fill(
    graph: list[int],
    cards: Sequence[int],
    chosen: Iterable[int],
    check: Callable[[], None] = lambda: None,
    most: float = math.inf,
) -> tuple[list[int], list[int]]:
    """(order, rests) of ``chosen`` by least fill, ties by the smaller table, then by number; changes ``graph``.

    WidthError at a table of more than 2^``most`` cells.
    """
    limit = 2.0**most if most < MOST_BITS else math.inf
    rests = [0] * len(graph)
    sequence: list[int] = []
    keys = {v: _key(graph, cards, v) for v in chosen}
    heap = [(*key, v) for v, key in keys.items()]
    heapq.heapify(heap)
    while heap:
        check()
        fill, size, v = heapq.heappop(heap)
        if keys.get(v) != (fill, size):
            continue
        if size > limit:
            raise WidthError(f"variable {v} needs a table of {math.log2(size):.1f} bits; the limit is {most:g}")
        del keys[v]
        sequence.append(v)
        rests[v] = graph[v]
        for u, key in _changed(graph, cards, v, fill, keys):
            if key != keys[u]:
                keys[u] = key
                heapq.heappush(heap, (*key, u))
    return sequence, rests


def _changed(
    graph: list[int], cards: Sequence[int], v: int, fill: int, keys: Mapping[int, tuple[int, int]]
) -> list[tuple[int, tuple[int, int]]]:
    """Eliminates v, which adds ``fill`` edges; (variable, key) of those of ``keys`` that it may have changed."""
    around = graph[v]
    touched = _eliminate(graph, v, filled=fill > 0)
    if fill:
        return [(u, _key(graph, cards, u)) for u in members(touched) if u in keys]
    # no edge is new: a neighbour only loses v, and the edges that joined v to its other neighbours would have been fill
    return [
        (u, (keys[u][0] - (graph[u] & ~around).bit_count(), keys[u][1] // cards[v]))
        for u in members(around)
        if u in keys
    ]


def _key(graph: Sequence[int], cards: Sequence[int], v: int) -> tuple[int, int]:
    """(edges that eliminating v adds, cells of its table)."""
    mask = graph[v]
    missing, size = 0, cards[v]
    rest = mask
    while rest:
        low = rest & -rest
        u = low.bit_length() - 1
        missing += (mask & ~graph[u]).bit_count() - 1
        size *= cards[u]
        rest ^= low
    return missing // 2, size


def _eliminate(graph: list[int], v: int, *, filled: bool) -> int:
    """Joins v's neighbours and removes v; the variables whose fill may have changed, as bits."""
    mask = graph[v]
    touched = mask
    gone = ~(1 << v)
    for u in members(mask):
        graph[u] = (graph[u] | mask) & ~(1 << u) & gone
        if filled:
            touched |= graph[u]
    graph[v] = 0
    return touched


def members(mask: int) -> list[int]:
    """The numbers of the bits, increasing."""
    result = []
    while mask:
        low = mask & -mask
        result.append(low.bit_length() - 1)
        mask ^= low
    return result


def sweep(graph: Sequence[int], bits: Sequence[float], check: Callable[[], None] = lambda: None) -> list[int]:
    """From an end of the graph, always the boundary variable that brings the fewest bits of new ones, ties by age.

    What a variable ``brings`` falls with each neighbour that joins the boundary, and does not change otherwise: a queue
    of all values that it had is cheaper than a look along the boundary, which may be thousands wide.
    """
    left, reached = (1 << len(graph)) - 1, 0
    sequence: list[int] = []
    brings: dict[int, float] = {}
    age: dict[int, int] = {}
    queue: list[tuple[float, int, int]] = []
    while left:
        check()
        if brings:
            value, _, v = heapq.heappop(queue)
            if v not in brings or value != _tie(brings[v]):
                continue
            del brings[v]
            left &= ~(1 << v)
            sequence.append(v)
            joining = members(graph[v] & left & ~reached)
        else:
            joining = [_last(graph, left, _last(graph, left, members(left & -left)[0]))]
        reached |= sum(1 << v for v in joining)
        changed = dict.fromkeys(joining)
        for v in joining:
            for u in members(graph[v] & left & reached):
                if u in brings:
                    brings[u] -= bits[v]
                    changed[u] = None
        for v in joining:
            age[v] = len(age)
            brings[v] = sum(bits[u] for u in members(graph[v] & left & ~reached)) - bits[v]
        for v in changed:
            heapq.heappush(queue, (_tie(brings[v]), age[v], v))
    return sequence


def _tie(bits: float) -> float:
    """What is the same but for the order in which it was added up."""
    return round(bits, 9)


def _last(graph: Sequence[int], left: int, start: int) -> int:
    """The last variable that a breadth-first walk reaches.

    Of twice such walks, one far from all others of its piece.
    """
    seen = level = 1 << start
    while True:
        after = reduce(or_, [graph[v] for v in members(level)]) & left & ~seen
        if not after:
            return min(members(level), key=lambda v: (graph[v].bit_count(), v))
        seen |= after
        level = after


def _along(graph: Sequence[int], bits: Sequence[float], sequence: Sequence[int]) -> Order:
    left = list(graph)
    rests = [0] * len(left)
    for v in sequence:
        rests[v] = left[v]
        _eliminate(left, v, filled=False)
    return _order((sequence, rests), bits)


def _order(search: tuple[Sequence[int], Sequence[int]], bits: Sequence[float]) -> Order:
    sequence, rests = search
    sizes = [bits[v] + sum(bits[u] for u in members(rests[v])) for v in sequence]
    width = max(sizes, default=0.0)
    return Order(
        tuple(sequence), tuple(rests), width, width + math.log2(max(1.0, sum(2.0 ** (s - width) for s in sizes)))
    )


BUCKET_CELLS = 1 << 10  # buckets are merged up to this many cells


class Bucket(NamedTuple):
    """``scope``: axes by their turn in the order, latest first; ``parent`` is −1 for a root.

    Buckets are listed children first.
    """

    scope: tuple[int, ...]
    shared: int
    parent: int
    tables: tuple[int, ...]
    children: tuple[int, ...]


def bucket_tree(cards: Sequence[int], scopes: Sequence[tuple[int, ...]], order: Order) -> tuple[Bucket, ...]:
    """The buckets of all variables in the order.

    Each scope (no empty one) is told to the bucket of its first variable.
    """
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
    """(parent of each bucket that stays, bucket of every variable, residuals of those buckets).

    A bucket is named by its last variable.
    """
    parents = {v: min(members(order.rests[v]), key=turn.__getitem__, default=-1) for v in order.sequence}
    residuals = {v: [v] for v in order.sequence}
    cells = {v: cards[v] * math.prod([cards[u] for u in members(order.rests[v])]) for v in order.sequence}
    for v in order.sequence:
        parent = parents[v]
        if parent < 0:
            continue
        size = cells[parent] * math.prod([cards[u] for u in residuals[v]])
        if size <= max(BUCKET_CELLS, cells[v]):
            residuals[parent] += residuals.pop(v)
            cells[parent] = size
    home = {u: v for v, residual in residuals.items() for u in residual}
    return {v: home[parents[v]] if parents[v] >= 0 else -1 for v in residuals}, home, residuals
