"""Votes of single data, for where pairs of neighbours do not do.

Each datum says, for every sight that looks like it, where the object would stand.

Its angle tells the roll, nothing the distance: so it votes at a number of sizes. A right pose gathers all of its data,
however far apart; a pair must have been detected both, and be neighbours. It costs far more than pairs do, and is for
what these leave open.

* ``single_votes``: the best poses by this, as ``Votes``
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices
from plogic.match.gamma.data import Data, centre_of
from plogic.match.oriented.asked import TypedData, typed_data
from plogic.match.oriented.oriented_match import Noise
from plogic.match.oriented.pair_index import PairIndex
from plogic.match.oriented.pair_votes import BENT, LARGEST, Votes

Singles = NDArray[np.float32]
Keys = NDArray[np.uint32]

CELL, SCALE, TURNS = 0.15, 0.35, 14
"""Votes are of one place that lie within one box: diameters, logarithm of scale, parts of the circle."""
SMALLEST = 40.0
"""Pixels across of an object at least: of smaller ones too little is apart from the rest to be told from clutter by so
few data."""
FEWEST = 4
"""Votes of a box that counts."""
HIT = 0.5
"""How often a sight is found where a pose is right, about."""
MOST = 20_000_000
"""Matches of a sight and a datum in all: types that would exceed it, in the order in which they are asked, are left
out."""
BLOCK = 500_000
"""Matches at a time."""
KEPT = 10
"""Times as many votes as are asked for, after which the worse ones are dropped."""
_BITS, _SPREAD = 18, np.uint32(2654435761)
"""Boxes are counted in a table of so many bits' length first, with others that fall on the same place: what is too few
there is too few."""


class _Matches(NamedTuple):
    """N matches of a sight and a datum, each at the two nearest of ``TURNS`` rolls.

    ``cell``, ``turn`` (N,); ``bent`` (N,) rad from the roll that the angle tells to the turn's; ``x``, ``y`` (N,)
    pixels from the image's middle; ``right``, ``down`` (N,) diameters from the object's middle to the sight, turned;
    ``others`` (N,) data that look the same.
    """

    cell: NDArray[np.int32]
    turn: NDArray[np.int32]
    bent: Singles
    x: Singles
    y: Singles
    right: Singles
    down: Singles
    others: Singles


def single_votes(
    index: PairIndex, data: Data, noise: Noise, kinds: Indices, most: int, check: Callable[[], None]
) -> tuple[Votes, int]:
    """The best votes for types ``kinds`` (K,), at most so many, the best first; and how many of the types were asked.

    ``check`` is called between blocks, and may raise to end it. A vote's weight is about ln of how much likelier its
    data are with the object than without, rounded.
    """
    typed = typed_data(data, index.looks)
    best: list[tuple[Floats, ...]] = []
    asked = matched = 0
    for kind in kinds:
        count = typed.count[index.sights.looks[kind]]  # of padding, −1, there is the last, of which there are none
        if matched + int(count.sum()) > MOST:
            continue
        asked, matched = asked + 1, matched + int(count.sum())
        for cells in _blocks(count.sum(axis=1)):
            check()
            best += _of_cells(index, int(kind), cells, typed, data, noise)
        if sum(len(rows[-1]) for rows in best) > KEPT * most:
            best = [_best(best, most)]
    kind, cell, x, y, roll, scale, score = _best(best, most)
    weight = np.rint(score).astype(np.intp)
    return Votes(kind.astype(np.intp), cell.astype(np.intp), np.column_stack([x, y]), roll, scale, weight), asked


def _blocks(count: Indices) -> Iterator[slice]:
    """Ranges of cells that have ``BLOCK`` matches each or are of one cell; ``count`` (C,) matches of each."""
    start, total = 0, 0
    for cell, own in enumerate(count):
        if total and total + own > BLOCK:
            yield slice(start, cell)
            start, total = cell, 0
        total += own
    yield slice(start, len(count))


def _of_cells(
    index: PairIndex, kind: int, cells: slice, typed: TypedData, data: Data, noise: Noise
) -> list[tuple[Floats, ...]]:
    """Boxes of some cells of one type, each as rows: kind, cell, x, y, roll, scale, score."""
    found: list[tuple[Floats, ...]] = []
    centre = centre_of(data.camera)  # boxes go from there, for it stays where it is when the camera is turned
    matches = _matches(index, kind, cells, typed, centre)
    if not len(matches.cell):
        return found
    wide, high = data.camera.width, data.camera.height
    sizes = np.exp(np.arange(np.log(SMALLEST) + SCALE / 2.0, np.log(LARGEST * min(wide, high)), SCALE))
    for offset in (0.0, 0.5):
        for size in sizes:
            rows, first = _boxed(matches, float(size), offset)
            if not len(rows):
                continue
            x, y, roll, score = _scored(matches, rows, first, float(size), float(wide * high), noise)
            where, scale = matches.cell[rows[first]].astype(float), size / index.sights.diameter[kind]
            same = np.full(len(first), float(kind)), np.full(len(first), scale)
            found.append((same[0], where, x + centre[0], y + centre[1], roll, same[1], score))
    return found


def _matches(index: PairIndex, kind: int, cells: slice, typed: TypedData, centre: Floats) -> _Matches:
    """All matches of some cells of one type; ``centre`` (2,) of the image."""
    sights = index.sights
    looks = sights.looks[kind, cells]
    cell, sight = np.nonzero(looks >= 0)
    looks = looks[cell, sight]
    row, datum = typed.of(looks)
    place, angle, count = (typed.places[datum] - centre).astype(np.float32), typed.angles[datum], typed.count[looks]
    cell = cell + cells.start
    told = np.mod(angle - sights.angle[kind, cell, sight][row], 2.0 * np.pi).astype(np.float32)
    at = (sights.xy[kind, cell, sight] / sights.diameter[kind]).astype(np.float32)[row]
    step = 2.0 * np.pi / TURNS
    turn = np.floor(told / np.float32(step) - np.float32(0.5)).astype(np.int32)
    turn = np.concatenate([turn, turn + 1])
    bent = (turn + np.float32(0.5)) * np.float32(step) - np.tile(told, 2)
    turn %= TURNS
    rolls = (np.arange(TURNS) + 0.5) * step
    cos, sin = np.cos(rolls).astype(np.float32)[turn], np.sin(rolls).astype(np.float32)[turn]
    x, y = np.tile(at, (2, 1)).T
    return _Matches(
        np.tile(cell[row].astype(np.int32), 2), turn, bent, np.tile(place[:, 0], 2), np.tile(place[:, 1], 2),
        cos * x - sin * y, sin * x + cos * y, np.tile(count[row].astype(np.float32), 2),
    )  # fmt: skip


def _boxed(matches: _Matches, size: float, offset: float) -> tuple[Indices, Indices]:
    """The matches (N,) in boxes that hold ``FEWEST`` or more, box by box, and (B,) where each box begins.

    ``size``: pixels a diameter.
    """
    keys = _keys(matches, size, offset)
    place = (keys * _SPREAD) >> np.uint32(32 - _BITS)
    rows = np.flatnonzero((np.bincount(place, minlength=1 << _BITS) >= FEWEST)[place])
    rows = rows[np.argsort(keys[rows], kind="stable")]
    count = np.diff(np.flatnonzero(np.diff(keys[rows].astype(np.int64), prepend=-1)), append=len(rows))
    full = count >= FEWEST
    rows, count = rows[np.repeat(full, count)], count[full]
    return rows, np.cumsum(count) - count


def _keys(matches: _Matches, size: float, offset: float) -> Keys:
    """(N,) a number for the box that each match votes for: of one cell, turn and place."""
    wide = np.float32(CELL * size)
    axes = []
    for place, away in ((matches.x, matches.right), (matches.y, matches.down)):
        middle = place / wide - away / np.float32(CELL)
        axes.append((middle + np.float32(offset - np.floor(middle.min()))).astype(np.uint32))
    high = np.uint32(axes[1].max() + 1)
    broad = np.uint32(axes[0].max() + 1)
    key = matches.cell.astype(np.uint32) * np.uint32(TURNS) + matches.turn.astype(np.uint32)
    return np.asarray((key * broad + axes[0]) * high + axes[1])


def _scored(
    matches: _Matches, rows: Indices, first: Indices, size: float, area: float, noise: Noise
) -> tuple[Floats, Floats, Floats, Floats]:
    """Of each box (B,) its middle, pixels from that of the image, its roll, and its score.

    ``area`` of the image, square pixels.

    A box is a place that a vote is as likely to be at as at any, so that smaller ones are more; they weigh as much
    together at each size.
    """
    count = np.diff(first, append=len(rows))
    spread = float(np.hypot(noise.angle, BENT))
    bell = np.exp(-0.5 * (matches.bent[rows] / spread) ** 2) * np.sqrt(2.0 * np.pi) / spread
    gain = np.log1p(HIT * (bell / matches.others[rows] * area / (CELL * size) ** 2 - 1.0))
    x, y = (
        np.add.reduceat((place[rows] - np.float32(size) * away[rows]).astype(float), first) / count
        for place, away in ((matches.x, matches.right), (matches.y, matches.down))
    )
    bent = np.add.reduceat(matches.bent[rows].astype(float), first) / count
    roll = (matches.turn[rows[first]] + 0.5) * (
        2.0 * np.pi / TURNS
    ) - bent / 2.0  # the box's own turn is as good a guess as what its votes say
    return x, y, roll, np.add.reduceat(gain, first) + 2.0 * np.log(size)


def _best(found: list[tuple[Floats, ...]], most: int) -> tuple[Floats, ...]:
    """The best of all rows, at most so many, the best first."""
    columns = [np.concatenate([rows[i] for rows in found]) if found else np.zeros(0) for i in range(7)]
    order = np.argsort(-columns[-1], kind="stable")[:most]
    return tuple(column[order] for column in columns)
