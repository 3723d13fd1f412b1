"""A discrete factor graph, its connected pieces, and beliefs in its variables.

Variables have a few states each, factors weigh their joint states. Pieces that no factor joins are independent, and are
solved apart.

Vocabulary, each with an example value:

* a *variable* is a number, 0, 1, 2, ...; ``cards[v]`` is how many states it has
* ``Factor((0, 2), table)``, log weights of the joint states of variables 0 and 2, shape ``(cards[0], cards[2])``; −inf
  is impossible
* ``FactorGraph((2, 3, 2), (Factor(...), ...))``; the weight of a joint state is the product of its factors' weights
* ``Part((4, 7, 9), (2, 3, 2), (((0, 1), table), ...))``: the variables 4, 7 and 9 of the whole, which are 0, 1 and 2 of
  the part; their cards; and the tables that weigh them, one a scope, in the part's numbering

``aligned`` puts a table's axes where another table has them; ``product``, ``log_sum`` and ``sliced`` compute with
tables.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from geometry.connected import roots
from plogic.base.walk import by_key

Tables = tuple[tuple[tuple[int, ...], NDArray[np.float64]], ...]
Scoped = tuple[tuple[int, ...], NDArray[np.float64]]


@dataclass(frozen=True)
class Factor:
    """``scope``: variables, strictly increasing.

    ``table``: natural logarithms, one axis a variable of the scope, no NaN, no +inf.
    """

    scope: tuple[int, ...]
    table: NDArray[np.float64]


@dataclass(frozen=True)
class FactorGraph:
    """The whole; ``constant`` is a log weight that every joint state has."""

    cards: tuple[int, ...]
    factors: tuple[Factor, ...]
    constant: float = 0.0


@dataclass(frozen=True)
class Beliefs:
    """Interval ``log_z`` of ln Σ weights.

    ``low``, ``high``: per variable, shape ``(card,)``, interval of P(state), the same arrays where exact.
    """

    log_z: tuple[float, float]
    low: tuple[NDArray[np.float64], ...]
    high: tuple[NDArray[np.float64], ...]

    @property
    def exact(self) -> bool:
        """Whether every interval is one number."""
        return self.log_z[0] == self.log_z[1] and all(a is b for a, b in zip(self.low, self.high, strict=True))


MANY_TABLES = 8  # tables of one scope that are first freed from their greatest entry, lest thousands of weak ones round each other off


class Part(NamedTuple):
    """One connected piece: increasing ``variables`` of the whole, their ``cards`` (≥ 2), and ``tables``.

    Scopes are strictly increasing.
    """

    variables: tuple[int, ...]
    cards: tuple[int, ...]
    tables: Tables


def split(graph: FactorGraph) -> tuple[float, list[Part]]:
    """(log weight that every joint state has, the pieces by least variable); variables of card 1 are in no piece."""
    cards = graph.cards
    constants = [graph.constant]
    by_scope: dict[tuple[int, ...], list[NDArray[np.float64]]] = {}
    trivial = 1 in cards
    for factor in graph.factors:
        scope, table = factor.scope, factor.table
        if trivial and any(cards[v] == 1 for v in scope):
            scope = tuple(v for v in scope if cards[v] > 1)
            table = table.reshape([cards[v] for v in scope])
        if scope:
            by_scope.setdefault(scope, []).append(table)
        else:
            constants.append(float(table))
    joined = {scope: _product(tables, constants) for scope, tables in by_scope.items()}
    return math.fsum(constants), _pieces(cards, joined)


def _product(tables: list[NDArray[np.float64]], constants: list[float]) -> NDArray[np.float64]:
    """The sum of log tables of one scope; of many, their greatest entries go to ``constants``."""
    if len(tables) == 1:
        return tables[0]
    if len(tables) < MANY_TABLES:
        return np.asarray(sum(tables[1:], tables[0]))
    stack = np.stack(tables).reshape(len(tables), -1)
    tops = stack.max(axis=1)
    tops[tops == -np.inf] = 0.0
    constants.extend(tops.tolist())
    return (stack - tops[:, None]).sum(axis=0).reshape(tables[0].shape)


def _pieces(cards: Sequence[int], joined: dict[tuple[int, ...], NDArray[np.float64]]) -> list[Part]:
    root = roots(len(cards), joined)
    members: dict[int, list[int]] = {}
    local = [0] * len(cards)
    for v, card in enumerate(cards):
        if card > 1:
            piece = members.setdefault(root[v], [])
            local[v] = len(piece)
            piece.append(v)
    tables: dict[int, list[tuple[tuple[int, ...], NDArray[np.float64]]]] = {r: [] for r in members}
    for scope, table in joined.items():
        tables[root[scope[0]]].append((tuple([local[v] for v in scope]), table))
    return [Part(tuple(piece), tuple([cards[v] for v in piece]), tuple(tables[r])) for r, piece in members.items()]


def connected(graph: FactorGraph) -> list[tuple[int, ...]]:
    """The variables of each connected piece, increasing, those of card 1 too; the pieces by their least variable."""
    root = roots(len(graph.cards), (factor.scope for factor in graph.factors))
    return list(map(tuple, by_key(zip(root, range(len(root)), strict=True)).values()))


Term = TypeVar("Term", bound="tuple[tuple[int, ...], NDArray[Any]]")


def aligned(scope: Sequence[int], table: NDArray[np.float64], place: Mapping[int, int]) -> NDArray[np.float64]:
    """A view of the table (axes by ``scope``) with as many axes as ``place``.

    Each variable's where it says, length 1 elsewhere.
    """
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
    """The tables in groups of joint tables of limited bits, the largest first, each in the first group with room."""
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
