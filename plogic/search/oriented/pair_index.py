"""The index over all types: in each view cell the pairs of neighbouring sights, by both looks and both angles to the line between them.

A pair in the image that has the same looks and nearly the same angles gives type, view cell, roll, scale and place at once.

* ``PairIndex``: E pairs of all types, sorted by key
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.angles import part_of_circle
from plogic.search.oriented.sights import sights_of
from plogic.search.ranges import taken

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.cloud import ObjectType
    from plogic.search.oriented.sights import Sights
    from plogic.search.type_index import TypeIndex
    from plogic.search.view_cells import ViewCells

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

NEIGHBOURS = 8
"""Nearest other sights in a cell that a sight is paired with."""
BINS = 16
"""Parts of the circle: an angle is looked up in its own and the two beside it."""
MOST = 2_000_000
"""Entries that all queries find together at most."""
BLOCK = 4_000_000
"""Pairs of sights at a time."""
_BESIDE = np.array([-1, 0, 1])


@dataclass(frozen=True, eq=False)
class PairIndex:
    """``looks``: names of the appearance types, by number; E pairs: ``key`` (E,) increasing, ``kind`` (E,) type, ``cell`` (E,) and the two sights.

    ``first``, ``second`` (E,) are places in the cell's row of ``sights``; the first's looks have the lower number.
    """

    indices: tuple[TypeIndex, ...]
    looks: tuple[str, ...]
    sights: Sights
    key: NDArray[np.int64]
    kind: NDArray[np.uint32]
    cell: NDArray[np.uint8]
    first: NDArray[np.uint16]
    second: NDArray[np.uint16]

    @cached_property
    def cells(self) -> tuple[ViewCells, ...]:
        """The view cells of each type: all of the same directions."""
        return tuple(index.cells for index in self.indices)

    @cached_property
    def centres(self) -> Floats:
        """(T, 3) middles of the types, object frame, metres."""
        return np.array([cells.centre for cells in self.cells]).reshape(-1, 3)

    @cached_property
    def points(self) -> Floats:
        """(T, F, 3) places of the types' features, metres, padded with zeros."""
        return _padded([index.points for index in self.indices])

    @cached_property
    def turns(self) -> Floats:
        """(T, F, 3) x axes of the features' frames, object frame, padded with zeros: what a datum's angle is on the screen."""
        return _padded([index.turns for index in self.indices])

    def found(self, looks: tuple[Indices, Indices], angles: tuple[Floats, Floats], most: int = MOST) -> tuple[Indices, Indices]:
        """Query and entry of all pairs that look alike: Q queries of ``looks`` (numbers, the lower first), ``angles`` to the line, radians.

        Where there are more than ``most``, the queries are left out that find the most entries: what is common says little (§5.1).
        """
        part, other = (part_of_circle(angle, BINS) for angle in angles)
        base = (looks[0].astype(np.int64) * len(self.looks) + looks[1]) * BINS
        order = np.argsort(base, kind="stable")  # neighbours in the index are looked up one after the other
        base, part, other = base[order], part[order], other[order]
        keys = ((base[:, None] + (part[:, None] + _BESIDE) % BINS) * BINS)[:, :, None] + ((other[:, None] + _BESIDE) % BINS)[:, None]
        keys = keys.reshape(len(base), len(_BESIDE) ** 2)
        low, high = np.searchsorted(self.key, keys, "left"), np.searchsorted(self.key, keys, "right")
        some = _fewest((high - low).sum(axis=1), most)
        query, entry = taken(low[some], high[some])
        return order[some[query]], entry


def looks_of(types: Sequence[ObjectType]) -> tuple[str, ...]:
    """Names of the appearance types of some object types, by number."""
    return tuple(sorted({name for kind in types for name in kind.lobes.types}))


def pair_index(indices: Sequence[TypeIndex]) -> PairIndex:
    """The index of some types."""
    looks = looks_of([index.object_type for index in indices])
    sights = sights_of(indices, {name: i for i, name in enumerate(looks)})
    rows = [_pairs(sights, kind, len(looks)) for kind in range(len(indices))]
    key, kind, cell, first, second = (np.concatenate([row[i] for row in rows]) if rows else np.zeros(0, np.int64) for i in range(5))
    order = np.argsort(key, kind="stable")
    return PairIndex(
        tuple(indices), looks, sights, key[order], kind[order].astype(np.uint32), cell[order].astype(np.uint8), first[order].astype(np.uint16),
        second[order].astype(np.uint16),
    )  # fmt: skip


def _pairs(sights: Sights, kind: int, count: int) -> tuple[NDArray[np.int64], ...]:
    """Key, kind, cell, first and second of one type's pairs."""
    looks, xy, angle = sights.looks[kind], sights.xy[kind].astype(float), sights.angle[kind].astype(float)
    wide = max(1, BLOCK // max(1, xy.shape[1] ** 2))
    blocks = [np.nonzero(_near(xy[i : i + wide], looks[i : i + wide])) for i in range(0, len(xy), wide)]
    cell = np.concatenate([block[0] + i * wide for i, block in enumerate(blocks)])
    first, second = (np.concatenate([block[side] for block in blocks]) for side in (1, 2))
    step = xy[cell, second] - xy[cell, first]
    line = np.arctan2(step[:, 1], step[:, 0])
    one, other = (part_of_circle(angle[cell, side] - line, BINS) for side in (first, second))
    key = ((looks[cell, first].astype(np.int64) * count + looks[cell, second]) * BINS + one) * BINS + other
    return key, np.full(len(key), kind, np.int64), cell, first, second


def _near(xy: Floats, looks: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(C, V, V) the neighbours in each cell, the one of lower looks first; of equal looks both ways round."""
    apart = ((xy[:, :, None] - xy[:, None]) ** 2).sum(axis=3)
    nobody = looks < 0
    apart[nobody] = np.inf
    apart[np.broadcast_to(nobody[:, None], apart.shape)] = np.inf
    apart[:, np.arange(apart.shape[1]), np.arange(apart.shape[1])] = np.inf
    near = np.zeros(apart.shape, bool)
    np.put_along_axis(near, np.argsort(apart, axis=2, kind="stable")[:, :, :NEIGHBOURS], values=True, axis=2)
    near = (near | np.swapaxes(near, 1, 2)) & np.isfinite(apart) & (apart > 0.0)
    return np.asarray(near & (looks[:, :, None] <= looks[:, None]))


def _padded(rows: Sequence[Floats]) -> Floats:
    most = max((len(row) for row in rows), default=0)
    return np.array([np.pad(row, ((0, most - len(row)), (0, 0))) for row in rows]).reshape(-1, most, 3)


def _fewest(count: Indices, most: int) -> Indices:
    """Those queries of counts (Q,), in order, that find the fewest, ``most`` in all."""
    order = np.argsort(count, kind="stable")
    return np.sort(order[np.cumsum(count[order]) <= most])
