"""Votes: each pair of neighbours in the image that looks like a pair of some cell of some type says where that would stand.

* ``Votes``: N of them, with how many others say nearly the same
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.angles import wrapped
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


def pair_votes(index: PairIndex, looks: Indices, data: Data, sigma: float) -> Votes:
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
    query, entry = index.found((looks[one], looks[other]), (data.angle[one] - line, data.angle[other] - line))
    kind, cell = index.kind[entry].astype(np.intp), index.cell[entry].astype(np.intp)
    first, second = index.first[entry].astype(np.intp), index.second[entry].astype(np.intp)
    sights = index.sights
    at = sights.xy[kind, cell, first].astype(float)
    model = sights.xy[kind, cell, second].astype(float) - at
    roll = line[query] - np.arctan2(model[:, 1], model[:, 0])
    scale = length[query] / np.hypot(*model.T)
    size = scale * sights.diameter[kind]
    right = (size >= SMALLEST) & (size <= LARGEST * data.camera.height)
    turned = min(COARSE + 2.0 * sigma, MOST_TURNED)
    for side, datum in ((first, one), (second, other)):
        right &= np.abs(wrapped(data.angle[datum[query]] - sights.angle[kind, cell, side] - roll)) < turned
    kind, cell, roll, scale, at, datum = kind[right], cell[right], wrapped(roll[right]), scale[right], at[right], one[query[right]]
    cos, sin = scale * np.cos(roll), scale * np.sin(roll)
    centre = data.ideal[datum] - np.column_stack([cos * at[:, 0] - sin * at[:, 1], sin * at[:, 0] + cos * at[:, 1]])
    votes = Votes(kind, cell, centre, roll, scale, np.zeros(len(kind), np.intp))
    return _gathered(votes, query[right], scale * sights.diameter[kind])


def _gathered(votes: Votes, query: Indices, size: Floats) -> Votes:
    """Of each box and cell one vote, with how many different pairs of the image vote for the box: in the fuller of two grids, half a box apart."""
    count = np.zeros(len(query), np.intp)
    for offset in (0.0, 0.5):
        box = _boxes(votes, size, offset)
        of_box = np.unique(box * (int(query.max(initial=0)) + 1) + query) // (int(query.max(initial=0)) + 1)
        number = np.bincount(of_box)[box]
        first = np.zeros(len(query), bool)
        first[np.unique(box * CELLS + votes.cell, return_index=True)[1]] = True
        count = np.maximum(count, np.where(first, number, 0))
    some = np.flatnonzero(count)
    return replace(votes, count=count).take(some)


def _boxes(votes: Votes, size: Floats, offset: float) -> Indices:
    """(N,) number of the box that each vote lies in: of one type, place, roll and size."""
    octave = np.floor(np.log(size) / SCALE + offset)
    wide = CELL * np.exp(octave * SCALE)
    column, row = (np.floor(votes.centre[:, axis] / wide + offset).astype(np.int64) for axis in (0, 1))
    turns = round(2.0 * np.pi / ROLL)
    turn = np.floor(np.mod(votes.roll, 2.0 * np.pi) / ROLL + offset).astype(np.int64) % turns
    key = (((votes.kind * 64 + octave.astype(np.int64)) * turns + turn) * 8192 + column % 8192) * 8192 + row % 8192
    return np.unique(key, return_inverse=True)[1]
