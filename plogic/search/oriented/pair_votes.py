"""Votes: each pair of neighbours in the image that looks like a pair of some cell of some type says where that would stand.

* ``Votes``: N of them, with how many others say nearly the same
* ``Raw``: those of all pairs, before they are counted
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.angles import wrapped
from plogic.search.oriented.pair_index import said
from plogic.search.view_cells import CELLS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.oriented.pair_index import PairIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

REACH = 45.0
"""Pixels between neighbours in the image."""
NEAREST = 4.0
"""Pixels between neighbours at least: nearer, the line between them says little."""
COARSE, MOST_TURNED = np.radians(14.0), np.radians(40.0)
"""How far an angle may be off because a cell is wide; two standard deviations of its noise come to that, and no more in all."""
SMALLEST, LARGEST = 20.0, 2.0
"""Pixels across, and the image's heights across, of an object at least and at most."""
_ROW = np.uint64(21)
"""Bits of the number of a vote."""
_OCTAVES, _SIDE = 20, 512
"""Sizes, and places along an axis, after which the numbers of boxes begin anew: of so different a size nothing is in one image."""
CELL, ROLL, SCALE = 0.3, np.pi / 6, 0.35
"""Votes are of one place that lie within one box: diameters, radians, logarithm of scale."""


@dataclass(frozen=True)
class Votes:
    """``kind``, ``cell`` (N,); ``centre`` (N, 2) ideal pixels; ``roll`` (N,) rad; ``scale`` (N,) pixels a metre; ``count`` (N,) of the like."""

    kind: Indices
    cell: Indices
    centre: Floats
    roll: Floats
    scale: Floats
    count: Indices

    def take(self, index: Indices) -> Votes:
        """Those at ``index``."""
        return Votes(*(getattr(self, field.name)[index] for field in fields(self)))


@dataclass(frozen=True)
class Raw:
    """Votes before they are counted, in the order of the pairs of the image: ``query`` (N,) which pair, ``pair`` (N, 2) rows of its data.

    ``boxes`` (2, N): numbers of the boxes of place, roll and size that each lies in, in two grids, half a box apart.
    """

    votes: Votes
    query: Indices
    pair: Indices
    boxes: NDArray[np.uint64]

    def without(self, taken: NDArray[np.bool_]) -> Raw:
        """Those of pairs neither datum of which is ``taken`` (A,)."""
        some = np.flatnonzero(~taken[self.pair].any(axis=1))
        return Raw(self.votes.take(some), self.query[some], self.pair[some], self.boxes[:, some])


def raw_votes(index: PairIndex, looks: Indices, data: Data, sigma: float) -> Raw:
    """All votes; ``looks`` (A,) numbers of the data's types, −1 for one that no sight has; ``sigma``: noise of angles, radians."""
    from scipy.spatial import cKDTree

    some = np.flatnonzero((looks >= 0) & np.isfinite(data.angle))
    some = some[np.lexsort((data.angle[some], looks[some], *data.ideal[some].T))]  # ties must not follow the order of Γ
    one, other = some[cKDTree(data.ideal[some]).query_pairs(REACH, output_type="ndarray").reshape(-1, 2)].T
    swap = looks[one] > looks[other]
    one, other = np.where(swap, other, one), np.where(swap, one, other)
    step = data.ideal[other] - data.ideal[one]
    length, line = np.hypot(*step.T), np.arctan2(step[:, 1], step[:, 0])
    far = length >= NEAREST
    one, other, length, line = one[far], other[far], length[far], line[far]
    tolerance = min(COARSE + 2.0 * sigma, MOST_TURNED)
    query, entry = index.found((looks[one], looks[other]), (data.angle[one] - line, data.angle[other] - line), tolerance)
    says = said(entry)
    diameter = index.sights.diameter[says.kind]
    size = length[query] / says.length
    right = np.flatnonzero((size >= SMALLEST) & (size <= LARGEST * data.camera.height))
    size, query, says = size[right], query[right], says.take(right)
    roll = wrapped(line[query] - says.line)
    cos, sin = size * np.cos(roll), size * np.sin(roll)
    x, y = says.place.T
    centre = data.ideal[one[query]] - np.column_stack([cos * x - sin * y, sin * x + cos * y])
    votes = Votes(says.kind, says.cell, centre, roll, size / diameter[right], np.zeros(len(right), np.intp))
    boxes = np.array([_boxes(votes, size, offset) for offset in (0.0, 0.5)])
    return Raw(votes, query, np.column_stack([one[query], other[query]]), boxes)


def counted(raw: Raw) -> Votes:
    """Of each box and cell one vote, with how many different pairs of the image vote for the box: in the fuller of the two grids."""
    count, row = np.zeros(len(raw.query), np.intp), np.arange(len(raw.query), dtype=np.uint64)
    for box in raw.boxes:
        both = np.sort((box << _ROW) | row)  # in each box the pairs of the image one after the other
        order, new_box = (both & ((np.uint64(1) << _ROW) - np.uint64(1))).astype(np.intp), _changes(both >> _ROW)
        of_box = np.cumsum(new_box) - 1
        number = np.bincount(of_box, new_box | _changes(raw.query[order])).astype(np.intp)
        cells = of_box.astype(np.uint64) * np.uint64(CELLS) + raw.votes.cell[order].astype(np.uint64)
        firsts = np.sort((cells << _ROW) | row)
        first = (firsts[_changes(firsts >> _ROW)] & ((np.uint64(1) << _ROW) - np.uint64(1))).astype(np.intp)
        count[order[first]] = np.maximum(count[order[first]], number[of_box[first]])
    some = np.flatnonzero(count)
    return replace(raw.votes, count=count).take(some)


def _changes(values: Indices | NDArray[np.uint64]) -> NDArray[np.bool_]:
    """(N,) whether each is another than the one before it."""
    return np.concatenate([np.ones(min(1, len(values)), bool), values[1:] != values[:-1]])


def _boxes(votes: Votes, size: Floats, offset: float) -> NDArray[np.uint64]:
    """(N,) a number for the box that each vote lies in: of one type, place, roll and size. It leaves room for ``_ROW`` bits."""
    octave = np.floor(np.log(size) / SCALE + offset)
    wide = CELL * np.exp(octave * SCALE)
    column, row = (np.floor(votes.centre[:, axis] / wide + offset).astype(np.int64) % _SIDE for axis in (0, 1))
    turns = round(2.0 * np.pi / ROLL)
    turn = np.floor(np.mod(votes.roll, 2.0 * np.pi) / ROLL + offset).astype(np.int64) % turns
    key = (((votes.kind * _OCTAVES + octave.astype(np.int64) % _OCTAVES) * turns + turn) * _SIDE + column) * _SIDE + row
    return np.asarray(key).astype(np.uint64)
