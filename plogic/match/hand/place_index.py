"""The index over all types that are known by places alone: triples of neighbouring features, by what they look like.

Of three features that are seen together, and of three appearances that look like them, weak perspective about the ray
of the first gives two poses in closed form (``plogic.match.hand.place_votes``). So the smallest sets that fix a pose
are looked up by three appearance types, of all object types at once.

* ``PlaceIndex``: the clouds of T types as padded arrays, and their triples
* ``Triples``: E of them, sorted by key; a type has ``MOST`` at most, of 104 bytes each, 0.6 MB
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from itertools import permutations as orders
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask, lengths
from kb.clouds.lobes import Feature
from plogic.match.gamma.data import Columns, Data
from plogic.match.hand.view_cells import ViewCells
from plogic.measures.distinctiveness import compatible

if TYPE_CHECKING:
    from plogic.match.hand.hand_models import TypeIndex

NEIGHBOURS = 10
"""Nearest features of a view cell among which the other two of a triple are sought."""
MOST = 6_000
"""Triples of a type at most: those that are neighbours in the most view cells."""
SETS = 500
"""Sets of three features that are looked at together."""
FLAT = 0.12
"""Sine of the angle at the first corner of a triple at least."""
SAME = 1e-3
"""Metres, per metre of the cloud's extent, within which a feature is carried onto another."""
NOTHING = -1
LEAST_VALUE = 0.2
"""Of a feature without any dv."""
PROBES = 12
"""Features of a cell that vote first, of the others but the three."""
SIDE = 64
"""Cells across of the map from directions to view cells."""


@dataclass(frozen=True)
class Triples(Columns):
    """``key`` (E,) of the three looks, in increasing order; ``kind`` (E,) the type; ``features`` (E, 3) in that order.

    ``first`` (E, 3) m, the place of the first; ``axes`` (E, 3, 3) rows x, y, normal of their plane, object frame;
    ``flat`` (E, 2, 2) the inverse of the sides from the first, columns, in x and y, 1/m.
    """

    key: NDArray[np.int64]
    kind: Indices
    features: Indices
    first: NDArray[np.float32]
    axes: NDArray[np.float32]
    flat: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class PlaceIndex:
    """Of T types, F features at most, padded; C view cells each, in the same directions.

    ``points`` (T, F, 3) m; ``visible`` (T, C, F); ``own`` (T, F) whether there is such a feature; ``centres`` (T, 3) m;
    ``diameters`` (T,) m; ``shown`` (T, F) number of its set of looks in ``sets``.
    """

    indices: tuple["TypeIndex", ...]
    points: Floats
    visible: Mask
    own: Mask
    centres: Floats
    diameters: Floats
    shown: Indices
    sets: tuple[frozenset[str], ...]

    @cached_property
    def looks(self) -> tuple[str, ...]:
        """Names of the appearance types, by number."""
        return tuple(sorted(frozenset().union(*self.sets)))

    @cached_property
    def number_of(self) -> dict[str, int]:
        """The number of each appearance type."""
        return {name: i for i, name in enumerate(self.looks)}

    @cached_property
    def values(self) -> Floats:
        """(T, F) what each feature is worth: its dv, and a little more; 0 of none."""
        return np.stack(
            [np.pad(LEAST_VALUE + index.weights, (0, self.own.shape[1] - len(index.weights))) for index in self.indices]
        )

    @property
    def directions(self) -> Floats:
        """(C, 3) unit, of the view cells."""
        return self.indices[0].cells.directions

    @cached_property
    def triples(self) -> Triples:
        """The triples of all types."""
        found = [_triples_of(self, kind) for kind in range(len(self.indices))]
        whole = Triples.joined(found)
        return whole.take(np.argsort(whole.key, kind="stable"))

    @cached_property
    def at(self) -> NDArray[np.float32]:
        """(3, T, F) m, the places of the features."""
        return np.ascontiguousarray(np.moveaxis(self.points, 2, 0), np.float32)

    @cached_property
    def middles(self) -> NDArray[np.float32]:
        """(3, T) m, the centres."""
        return np.ascontiguousarray(self.centres.T, np.float32)

    def make_ready(self) -> None:
        """Compute now what is otherwise computed when it is first asked for."""
        _ = self.triples, self.at, self.middles, self.probes, self.cell_map, self.values

    @cached_property
    def probes(self) -> Indices:
        """(T, C, ``PROBES``) features that a cell shows, those first whose looks are rare in Σo; −1 for none."""
        often = np.bincount(self.shown[self.own], minlength=len(self.sets))
        order = np.where(self.visible, often[self.shown][:, None], np.iinfo(np.intp).max)
        first = np.argsort(order, axis=2, kind="stable")[:, :, :PROBES]
        return np.where(np.take_along_axis(self.visible, first, axis=2), first, -1)

    @cached_property
    def cell_map(self) -> NDArray[np.int16]:
        """(``SIDE``, ``SIDE``) the view cell nearest to each direction of ``octahedral``."""
        step = (np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0
        x, y = np.meshgrid(step, step, indexing="ij")
        z = 1.0 - np.abs(x) - np.abs(y)
        under = np.maximum(-z, 0.0)
        way = np.stack([x - np.copysign(under, x), y - np.copysign(under, y), z], axis=-1)
        return np.asarray((way @ self.directions.T).argmax(axis=2).astype(np.int16))

    def cells_of(self, way: NDArray[np.floating[Any]]) -> Indices:
        """(N,) the view cell, about the nearest, of directions (3, N) of any length."""
        x, y, z = way / np.maximum(np.abs(way).sum(axis=0), np.float32(1e-12))
        under = z < 0.0
        u = np.where(under, np.copysign(1.0 - np.abs(y), x), x)
        v = np.where(under, np.copysign(1.0 - np.abs(x), y), y)
        row, column = (np.clip((w + 1.0) * (SIDE / 2), 0, SIDE - 1).astype(np.intp) for w in (u, v))
        return np.asarray(self.cell_map[row, column], np.intp)

    def allowed(self, data: Data) -> Mask:
        """(S, A) the data that look as one of each set."""
        names, which = data.by_look
        return np.asarray(compatible(list(self.sets), list(names))[:, which])


def place_index(indices: Sequence["TypeIndex"]) -> PlaceIndex:
    """The index of at least one type."""
    looks = [[frozenset(a.type for a in feature.appearances) for feature in _features(index)] for index in indices]
    sets = tuple(sorted({some for row in looks for some in row}, key=sorted))
    number = {some: i for i, some in enumerate(sets)}
    most = max(len(row) for row in looks)
    return PlaceIndex(
        tuple(indices),
        np.stack([np.pad(index.points, ((0, most - len(index.points)), (0, 0))) for index in indices]),
        np.stack([np.pad(index.cells.visible, ((0, 0), (0, most - len(index.points)))) for index in indices]),
        np.array([np.arange(most) < len(index.points) for index in indices]),
        np.array([index.cells.centre for index in indices]),
        np.array([index.cells.diameter for index in indices]),
        np.array([[number[some] for some in row] + [0] * (most - len(row)) for row in looks], np.intp),
        sets,
    )


def _features(index: "TypeIndex") -> Sequence[Feature]:
    return index.object_type.seen_features


def _triples_of(index: PlaceIndex, kind: int) -> Triples:
    """The triples of one type, in no order."""
    own, points = index.indices[kind], index.indices[kind].points
    sets = least_sets(neighbours(own.cells), permutations(points, own.object_type.symmetries))
    three, looks = _first_triples(sets, _looks_of(index, kind), points)
    u, v = (points[three[:, k]] - points[three[:, 0]] for k in (1, 2))
    cross = np.cross(u, v)
    x, normal = u / lengths(u)[:, None], cross / lengths(cross)[:, None]
    axes = np.stack([x, np.cross(normal, x), normal], axis=1)
    sides = np.einsum("nij,knj->nik", axes[:, :2], np.stack([u, v]))
    count = len(index.looks)
    return Triples(
        looks @ np.array([count * count, count, 1]),
        np.full(len(three), kind),
        three,
        points[three[:, 0]].astype(np.float32),
        axes.astype(np.float32),
        np.linalg.inv(sides).astype(np.float32),
    )


def _first_triples(sets: Indices, looks: Indices, points: Floats) -> tuple[Indices, Indices]:
    """The first ``MOST`` of ``_by_looks`` that do not lie nearly on a line; of no more sets than these need."""
    found = [(np.zeros((0, 3), np.intp), np.zeros((0, 3), np.intp))]
    count = start = 0
    while start < len(sets) and count < MOST:
        three, own = _by_looks(sets[start : start + SETS], looks)
        u, v = (points[three[:, k]] - points[three[:, 0]] for k in (1, 2))
        some = np.flatnonzero(lengths(np.cross(u, v)) > FLAT * lengths(u) * lengths(v))[: MOST - count]
        found.append((three[some], own[some]))
        count, start = count + len(some), start + SETS
    three, own = (np.concatenate(column) for column in zip(*found, strict=True))
    return three, own


def _looks_of(index: PlaceIndex, kind: int) -> Indices:
    """(F, M) the numbers of the looks of each feature of a type, −1 where it has fewer."""
    own = [sorted(index.number_of[name] for name in index.sets[k]) for k in index.shown[kind][index.own[kind]]]
    most = max(map(len, own))
    return np.array([row + [NOTHING] * (most - len(row)) for row in own], np.intp)


def _by_looks(sets: Indices, looks: Indices) -> tuple[Indices, Indices]:
    """Sets of three features (N, 3) in each order in which their ``looks`` (F, M) increase; those looks (E, 3).

    Equal looks are in any order. The order of the sets is kept.
    """
    found = [(np.zeros(0, np.intp), np.zeros((0, 3), np.intp), np.zeros((0, 3), np.intp))]
    for way in map(list, orders(range(3))):
        three = sets[:, way]
        a, b, c = np.moveaxis(looks[three], 1, 0)
        rising = b[:, :, None] <= c[:, None]
        for least in a.T:
            right, second, third = np.nonzero(((least >= 0)[:, None] & (least[:, None] <= b))[:, :, None] & rising)
            found.append((right, three[right], np.column_stack([least[right], b[right, second], c[right, third]])))
    of, three, own = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(of, kind="stable")
    return three[order], own[order]


def neighbours(cells: ViewCells) -> Indices:
    """(N, 3) features in increasing order, triples of neighbours in some view cell, those of the most cells first."""
    count = cells.visible.shape[1]
    near = min(NEIGHBOURS, count - 1)
    if near < 2:
        return np.zeros((0, 3), np.intp)
    x, y = np.moveaxis(cells.xy, 2, 0)
    cell, first = np.nonzero(cells.visible)
    apart = (x[cell, first, None] - x[cell]) ** 2 + (y[cell, first, None] - y[cell]) ** 2
    apart[~cells.visible[cell]] = np.inf
    apart[np.arange(len(first)), first] = np.inf
    order = np.argsort(apart, axis=1, kind="stable")[:, :near]
    there = np.isfinite(np.take_along_axis(apart, order, axis=1))
    one, other = np.array(list(combinations(range(near), 2)), np.intp).T
    row, pair = np.nonzero(there[:, one] & there[:, other])
    three = first[row], order[row, one[pair]], order[row, other[pair]]
    least, most = np.minimum.reduce(three), np.maximum.reduce(three)
    middle = sum(three) - least - most
    code, often = np.unique((least * count + middle) * count + most, return_counts=True)
    code = code[np.argsort(-often, kind="stable")]
    return np.column_stack([code // (count * count), code // count % count, code % count])


def permutations(points: Floats, symmetries: Floats) -> Indices:
    """(S, F) where each symmetry (S, 4, 4) carries each feature (F, 3).

    A symmetry that carries one onto none is left out.
    """
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 1.0
    rows = []
    for motion in symmetries:
        gap = np.linalg.norm((points @ motion[:3, :3].T + motion[:3, 3])[:, None] - points[None], axis=2)
        if (gap.min(axis=1, initial=np.inf) < SAME * extent).all():
            rows.append(gap.argmin(axis=1))
    return np.array(rows, dtype=np.intp).reshape(-1, len(points))


def least_sets(sets: Indices, moves: Indices) -> Indices:
    """One of each family of sets (N, k), in increasing order, that the permutations (S, F) carry onto each other.

    The least, in the order in which the families come.
    """
    base = moves.shape[1] ** np.arange(sets.shape[1])[::-1]
    carried = np.sort(moves[:, sets], axis=2)
    code = carried @ base
    first = np.sort(np.unique(code.min(axis=0), return_index=True)[1])
    return np.asarray(carried[code.argmin(axis=0)[first], first])


def unique_sets(rows: Indices, moves: Indices) -> Mask:
    """(N,) one of each family of rows (N, k) of feature indices that the permutations (S, F) carry onto each other.

    The least.
    """
    if not len(rows):
        return np.zeros(0, dtype=bool)
    base = moves.shape[1] ** np.arange(rows.shape[1])[::-1]
    return np.asarray((moves[:, rows] @ base).min(axis=0) == rows @ base)
