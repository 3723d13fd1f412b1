"""The index over all types: each view cell's pairs of neighbouring sights, by both looks and both angles.

Angles to the line between them.

A *sight* is one appearance of one feature: a lobe. From a cell it is seen if its lobe holds the viewpoint and the
feature is not Behind its host. A pair in the image that has the same looks and nearly the same angles gives type, view
cell, roll, scale and place at once.

* ``Sights``: of T types, C cells each, at most V sights a cell, as arrays over all types
* ``PairIndex``: E pairs of all types, sorted by key
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import in_lobe
from plogic.base.errors import InputError
from plogic.match.gamma.data import Columns
from plogic.match.gamma.grid import part_of_circle, screen_angle, taken
from plogic.match.hand.hand_models import TypeIndex
from plogic.match.hand.view_cells import DISTANCE, ViewCells

NOTHING = -1


@dataclass(frozen=True, eq=False)
class Sights:
    """Of T types and C cells, V sights at most, padded.

    Attributes:
        feature: (T, C, V) whose sight it is, −1 where there is none.
        looks: (T, C, V) number of its appearance type, −1 where there is none.
        xy: (T, C, V, 2) metres in the plane through the centre, x right and y down, from the centre.
        angle: (T, C, V) radians clockwise on the screen: what a detector's angle is, the x axis of the feature's frame.
        diameter: (T,) metres.
    """

    feature: NDArray[np.int32]
    looks: NDArray[np.int32]
    xy: NDArray[np.float32]
    angle: NDArray[np.float32]
    diameter: Floats


def sights_of(indices: Sequence[TypeIndex], number_of: Mapping[str, int]) -> Sights:
    """The sights of some types; ``number_of``: a number for each appearance type."""
    rows = [_of_type(index, number_of) for index in indices]
    most = max((row[0].shape[1] for row in rows), default=0)

    def stacked(column: int, empty: float) -> Floats:
        arrays = [row[column] for row in rows]
        return np.stack(
            [
                np.pad(a, [(0, 0), (0, most - a.shape[1]), *[(0, 0)] * (a.ndim - 2)], constant_values=empty)
                for a in arrays
            ]
        )

    return Sights(
        stacked(0, NOTHING).astype(np.int32), stacked(1, NOTHING).astype(np.int32), stacked(2, 0.0).astype(np.float32),
        stacked(3, 0.0).astype(np.float32), np.array([index.cells.diameter for index in indices]),
    )  # fmt: skip


def _of_type(index: TypeIndex, number_of: Mapping[str, int]) -> tuple[Floats, ...]:
    """Features, looks, places and angles (C, V, ...) of one type's cells, padded on the right."""
    cells, table = index.cells, index.object_type.lobes
    viewpoints = cells.centre + DISTANCE * cells.diameter * cells.directions
    shown = in_lobe(table, viewpoints) & cells.visible[:, table.feature]
    count = shown.sum(axis=1)
    cell, lobe = np.nonzero(shown)
    slot = np.arange(len(cell)) - np.repeat(np.cumsum(count) - count, count)
    feature = table.feature[lobe]
    looks = np.array([number_of[name] for name in table.types], np.int64)[lobe]
    local = np.einsum("nij,nj->ni", cells.cell_from_object[cell], index.points[feature] - viewpoints[cell])
    angle = screen_angle(np.einsum("nij,nj->ni", cells.cell_from_object[cell], index.turns[feature]), local)
    shape = len(count), int(count.max(initial=0))
    features, kinds, angles = np.full(shape, float(NOTHING)), np.full(shape, float(NOTHING)), np.zeros(shape)
    places = np.zeros((*shape, 2))
    features[cell, slot], kinds[cell, slot], angles[cell, slot] = feature, looks, angle
    places[cell, slot] = cells.xy[cell, feature]
    return features, kinds, places, angles


NEIGHBOURS = 8
"""Nearest other sights in a cell that a sight is paired with."""
BINS = 32
"""Parts of the circle by which pairs are sorted."""
_BESIDE = np.arange(-2, 3)
"""An angle is looked up in its own part and the two on either side: all that are less than 22.5 degrees off, and some
that are more."""
FINE = 256
"""Parts of the circle to which an entry tells its angles."""
MOST = 2_000_000
"""Entries that all queries find together at most."""
BLOCK = 4_000_000
"""Pairs of sights at a time."""
SHORTEST, STEP = 1e-3, 0.03
"""Of the lengths that an entry tells, the least, in diameters, and the step between two, as a share: 256 of them reach
to twice a diameter."""
TYPES = 1 << 17
"""Types that one index holds at most."""
_FAR = 127.0
"""The middle of an object is told in 127ths of its diameter."""


class Lobes(NamedTuple):
    """Of T types, padded: (T, L) ``feature``, number of what it ``looks`` like, ``cos_half``.

    ``axis`` (T, L, 3) unit, object frame.

    ``own`` (T,): how many lobes each has.
    """

    own: Indices
    feature: Indices
    looks: Indices
    axis: Floats
    cos_half: Floats


@dataclass(frozen=True, eq=False)
class PairIndex:
    """``looks``: names of the appearance types, by number.

    E pairs: ``key`` (E,) increasing, ``entry`` (E,) what each says, as numbers in 64 bits.

    ``turned`` (E, 2): in which of ``FINE`` parts of the circle the angle of each of the two is, to the line from the
    first to the second. The first's looks have the lower number.
    """

    indices: tuple[TypeIndex, ...]
    looks: tuple[str, ...]
    sights: Sights
    key: NDArray[np.int64]
    entry: NDArray[np.uint64]
    turned: NDArray[np.uint8]

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
        """(T, F, 3) x axes of the features' frames, object frame, padded with zeros.

        What a datum's angle is on the screen.
        """
        return _padded([index.turns for index in self.indices])

    @cached_property
    def feature_types(self) -> tuple[tuple[str, ...], Indices]:
        """Names of the types that features are of, and by number that of each feature (T, F), padded with zeros."""
        types = [[feature.type for feature in index.object_type.seen_features] for index in self.indices]
        names = tuple(sorted({name for row in types for name in row}))
        number = {name: i for i, name in enumerate(names)}
        table = np.zeros((len(types), max((len(row) for row in types), default=0)), np.intp)
        for row, own in zip(table, types, strict=True):
            row[: len(own)] = [number[name] for name in own]
        return names, table

    @cached_property
    def lobes(self) -> Lobes:
        """The lobes of the types."""
        number = {name: i for i, name in enumerate(self.looks)}
        tables = [index.object_type.lobes for index in self.indices]
        count = np.array([len(table.feature) for table in tables], np.intp)
        most = int(count.max(initial=0))
        feature, looks = np.zeros((len(tables), most), np.intp), np.zeros((len(tables), most), np.intp)
        axis, cos_half = np.zeros((len(tables), most, 3)), np.zeros((len(tables), most))
        for row, (table, own) in enumerate(zip(tables, count, strict=True)):
            feature[row, :own], looks[row, :own] = table.feature, [number[name] for name in table.types]
            axis[row, :own], cos_half[row, :own] = table.axis, table.cos_half
        return Lobes(count, feature, looks, axis, cos_half)

    @cached_property
    def sizes(self) -> NDArray[np.float32] | None:
        """(2, T, looks) m, the least and the most that a type's sights of some looks are wide.

        0 and infinity where one of them is of unknown size.

        None where no size is known at all.
        """
        tables = [index.object_type.lobes for index in self.indices]
        if not any(np.isfinite(table.size).any() for table in tables):
            return None
        shape = len(tables), len(self.looks)
        sizes = np.stack([np.full(shape, np.inf, np.float32), np.zeros(shape, np.float32)])
        for k, table in enumerate(tables):
            looks = self.lobes.looks[k, : len(table.size)]
            np.minimum.at(sizes[0, k], looks, np.where(np.isfinite(table.size), table.size, 0.0))
            np.maximum.at(sizes[1, k], looks, np.where(np.isfinite(table.size), table.size, np.inf))
        return sizes

    def found(
        self, looks: tuple[Indices, Indices], angles: tuple[Floats, Floats], tolerance: float, most: int = MOST
    ) -> tuple[Indices, NDArray[np.uint64], NDArray[np.uint8]]:
        """All N pairs that look alike.

        Query and entry (N,), and by how much each of the two angles (N, 2) is off, in ``FINE``ths of the circle.

        Q queries of ``looks`` (numbers, the lower first), ``angles`` to the line, radians. Those are found both angles
        of which are within
        ``tolerance``, radians, as far as ``FINE`` and ``BINS`` tell. Where more than ``most`` are to be looked at, the
        queries are left out that
        find the most entries: what is common says little (§5.1).
        """
        part, other = (part_of_circle(angle, BINS) for angle in angles)
        base = (looks[0].astype(np.int64) * len(self.looks) + looks[1]) * BINS
        order = np.argsort(base, kind="stable")  # neighbours in the index are looked up one after the other
        rows = (base[order, None] + (part[order, None] + _BESIDE) % BINS) * BINS
        start = (other[order, None] + _BESIDE[0]) % BINS
        over = np.maximum(
            start + len(_BESIDE) - BINS, 0
        )  # of the parts beside it, those that come after the last part of the circle
        low = np.searchsorted(self.key, np.concatenate([rows + start, np.where(over > 0, rows, -1)], axis=1), "left")
        high = np.searchsorted(
            self.key,
            np.concatenate([rows + start + len(_BESIDE) - over, np.where(over > 0, rows + over, -1)], axis=1),
            "left",
        )
        some = _fewest((high - low).sum(axis=1), most)
        row, at = taken(low[some], high[some])
        query = order[some[row]]
        asked = np.column_stack([part_of_circle(angle, FINE) for angle in angles]).astype(np.uint8)
        off = np.abs((np.asarray(self.turned)[at] - asked[query]).view(np.int8)).view(
            np.uint8
        )  # around the circle as bytes go around
        near = np.flatnonzero((off <= tolerance / (2.0 * np.pi) * FINE).all(axis=1))
        return query[near], np.asarray(self.entry)[at[near]], off[near]


@dataclass(frozen=True)
class Said(Columns):
    """Of entries (N,): ``kind`` type, ``cell``, ``line`` rad of the way between sights on the screen, ``length``.

    ``place`` (N, 2): where the first is there, from the object's middle. Lengths and places in diameters.
    """

    kind: Indices
    cell: Indices
    line: Floats
    length: Floats
    place: Floats


def said(entry: NDArray[np.uint64]) -> Said:
    """Unpacked: as exact as eight bits a number are, half a percent of a diameter, 0.7 degrees, 1.5 % of a length."""
    kind, (cell, line, length, x, y) = (
        entry >> np.uint64(40),
        ((entry >> np.uint64(shift)) & np.uint64(0xFF) for shift in (32, 24, 16, 8, 0)),
    )
    place = (np.column_stack([x, y]).astype(float) - 128.0) / _FAR
    return Said(
        kind.astype(np.intp), cell.astype(np.intp), (line.astype(float) + 0.5) * (2.0 * np.pi / FINE),
        SHORTEST * np.exp(STEP * length.astype(float)), place,
    )  # fmt: skip


def _packed(kind: int, cell: Indices, line: Floats, length: Floats, place: Floats) -> NDArray[np.uint64]:
    """The entries (N,) that say this of a type, ``length`` (N,) and ``place`` (N, 2) in diameters."""
    steps = np.clip(np.rint(np.log(length / SHORTEST) / STEP), 0, 255)
    at = np.clip(np.rint(_FAR * place) + 128.0, 0, 255)
    parts = np.full(len(cell), kind), cell, part_of_circle(line, FINE), steps, at[:, 0], at[:, 1]
    return np.bitwise_or.reduce(
        [part.astype(np.uint64) << np.uint64(shift) for part, shift in zip(parts, (40, 32, 24, 16, 8, 0), strict=True)]
    )


def looks_of(types: Sequence[ObjectType]) -> tuple[str, ...]:
    """Names of the appearance types of some object types, by number."""
    return tuple(sorted({name for kind in types for name in kind.lobes.types}))


def pair_index(indices: Sequence[TypeIndex]) -> PairIndex:
    """The index of some types.

    Raises:
        InputError: they are more than ``TYPES``.
    """
    if len(indices) > TYPES:
        msg = f"{len(indices)} types are more than one index holds; at most {TYPES} can be searched for together"
        raise InputError(msg)
    looks = looks_of([index.object_type for index in indices])
    sights = sights_of(indices, {name: i for i, name in enumerate(looks)})
    rows = [_pairs(sights, kind, len(looks)) for kind in range(len(indices))]
    empty = np.zeros(0, np.int64), np.zeros(0, np.uint64), np.zeros((0, 2), np.uint8)
    key, entry, turned = (np.concatenate(columns) for columns in zip(*(rows or [empty]), strict=True))
    order = np.argsort(key, kind="stable")
    return PairIndex(tuple(indices), looks, sights, key[order], entry[order], turned[order])


def _pairs(sights: Sights, kind: int, count: int) -> tuple[NDArray[np.int64], NDArray[np.uint64], NDArray[np.uint8]]:
    """Key, entry and fine angles of one type's pairs."""
    looks, xy, angle = sights.looks[kind], sights.xy[kind].astype(float), sights.angle[kind].astype(float)
    wide = max(1, BLOCK // max(1, xy.shape[1] ** 2))
    blocks = [np.nonzero(_near(xy[i : i + wide], looks[i : i + wide])) for i in range(0, len(xy), wide)]
    cell = np.concatenate([block[0] + i * wide for i, block in enumerate(blocks)])
    first, second = (np.concatenate([block[side] for block in blocks]) for side in (1, 2))
    step = xy[cell, second] - xy[cell, first]
    line = np.arctan2(step[:, 1], step[:, 0])
    turned = [angle[cell, side] - line for side in (first, second)]
    one, other = (part_of_circle(turn, BINS) for turn in turned)
    key = ((looks[cell, first].astype(np.int64) * count + looks[cell, second]) * BINS + one) * BINS + other
    diameter = float(sights.diameter[kind])
    entry = _packed(kind, cell, line, np.hypot(*step.T) / diameter, xy[cell, first] / diameter)
    return key, entry, np.column_stack([part_of_circle(turn, FINE) for turn in turned]).astype(np.uint8)


def _near(xy: Floats, looks: NDArray[np.int32]) -> Mask:
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
