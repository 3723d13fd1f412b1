"""Votes: each pair of neighbours in the image that looks like a pair of some type's cell places that type.

* ``Votes``: N of them, with how much says nearly the same
* ``Raw``: those of all pairs, before they are counted
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from plogic.match.gamma.data import Columns, Data, centre_of
from plogic.match.gamma.grid import wrapped
from plogic.match.hand.view_cells import CELLS
from plogic.match.learned.agreement import SIZES
from plogic.match.oriented.pair_index import FINE, PairIndex, said

REACH = 45.0
"""Pixels between neighbours in the image."""
NEAREST = 4.0
"""Pixels between neighbours at least: nearer, the line between them says little."""
COARSE, MOST_TURNED = np.radians(14.0), np.radians(40.0)
"""How far an angle may be off because a cell is wide; two standard deviations of its noise come to that, and no more in
all."""
BENT = np.radians(8.0)
"""Standard deviation of how much a sight is turned because a cell is wide."""
WHOLE = 16
"""Weight of a vote both angles of which fit."""
LIGHT = 1
"""Weight of a vote that is not counted: nearly half of all weigh no more, of the right ones one in twelve (counted
once, by hand)."""
SMALLEST, LARGEST = 20.0, 2.0
"""Pixels across, and the image's shorter sides across, of an object at least and at most."""
_ROW = np.uint64(21)
"""Bits of the number of a vote."""
_OCTAVES, _SIDE = 20, 512
"""Sizes, and places along an axis, after which the numbers of boxes begin anew: of so different a size nothing is in
one image."""
AS_WIDE = float(np.exp(SIZES))
"""Ratio of two widths that are taken for the same: what cells, pairs and detectors may be off together; as of learned
types."""
CELL, ROLL, SCALE = 0.3, np.pi / 6, 0.35
"""Votes are of one place that lie within one box: diameters, radians, logarithm of scale."""


@dataclass(frozen=True)
class Votes(Columns):
    """``kind``, ``cell`` (N,); ``centre`` (N, 2) ideal pixels; ``roll`` (N,) rad; ``scale`` (N,) pixels a metre.

    ``weight`` (N,): that of the vote, ``WHOLE`` at most; once they are counted, that of all votes of its box, of each
    pair of the image the best.
    """

    kind: Indices
    cell: Indices
    centre: Floats
    roll: Floats
    scale: Floats
    weight: Indices


@dataclass(frozen=True)
class Raw:
    """Votes before they are counted, in the order of the pairs of the image.

    ``query`` (N,) which pair, ``pair`` (N, 2) rows of its data.

    ``boxes`` (2, N): numbers of the boxes of place, roll and size that each lies in, in two grids, half a box apart.
    """

    votes: Votes
    query: Indices
    pair: Indices
    boxes: NDArray[np.uint64]

    def without(self, taken: Mask) -> "Raw":
        """Those of pairs neither datum of which is ``taken`` (A,)."""
        some = np.flatnonzero(~taken[self.pair].any(axis=1))
        return Raw(self.votes.take(some), self.query[some], self.pair[some], self.boxes[:, some])


def raw_votes(index: PairIndex, looks: Indices, data: Data, sigma: float) -> Raw:
    """All votes; ``looks`` (A,) numbers of the data's types, −1 for one that no sight has.

    ``sigma``: noise of angles, radians.
    """
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
    query, entry, off = index.found(
        (looks[one], looks[other]), (data.angle[one] - line, data.angle[other] - line), tolerance
    )
    weight = _fit(off, sigma)
    heavy = np.flatnonzero(weight > LIGHT)
    query, weight, says = query[heavy], weight[heavy], said(entry[heavy])
    diameter = index.sights.diameter[says.kind]
    size = length[query] / says.length
    fits = (size >= SMALLEST) & (size <= LARGEST * min(data.camera.width, data.camera.height))
    if index.sizes is not None and np.isfinite(data.scale).any():
        for side in (one[query], other[query]):
            fits &= _as_wide(index.sizes[:, says.kind, looks[side]], data.scale[side], size / diameter)
    right = np.flatnonzero(fits)
    size, query, says, weight = size[right], query[right], says.take(right), weight[right]
    roll = wrapped(line[query] - says.line)
    cos, sin = size * np.cos(roll), size * np.sin(roll)
    x, y = says.place.T
    centre = data.ideal[one[query]] - np.column_stack([cos * x - sin * y, sin * x + cos * y])
    votes = Votes(says.kind, says.cell, centre, roll, size / diameter[right], weight)
    boxes = np.array([_boxes(votes, votes.centre - centre_of(data.camera), size, offset) for offset in (0.0, 0.5)])
    return Raw(votes, query, np.column_stack([one[query], other[query]]), boxes)


def _as_wide(sizes: NDArray[np.float32], scale: Floats, per_metre: Floats) -> Mask:
    """(N,) whether data of ``scale`` px, NaN where unknown, fit ``sizes`` (2, N), m, at so many pixels a metre."""
    least, most = sizes
    return np.asarray(
        np.isnan(scale) | ((scale >= least * per_metre / AS_WIDE) & (scale <= most * per_metre * AS_WIDE))
    )


def counted(raw: Raw) -> Votes:
    """Of each box and cell one vote, with the weight of all pairs of the image that vote for the box.

    In the fuller of the two grids.
    """
    weight, row = np.zeros(len(raw.query), np.intp), np.arange(len(raw.query), dtype=np.uint64)
    for box in raw.boxes:
        both = np.sort((box << _ROW) | row)  # in each box the pairs of the image one after the other
        order, new_box = (both & ((np.uint64(1) << _ROW) - np.uint64(1))).astype(np.intp), _changes(both >> _ROW)
        of_box = np.cumsum(new_box) - 1
        pairs = np.flatnonzero(new_box | _changes(raw.query[order]))
        best = np.maximum.reduceat(raw.votes.weight[order], pairs) if len(pairs) else np.zeros(0)
        whole = np.bincount(of_box[pairs], best).astype(np.intp)
        cells = of_box.astype(np.uint64) * np.uint64(CELLS) + raw.votes.cell[order].astype(np.uint64)
        firsts = np.sort((cells << _ROW) | row)
        first = (firsts[_changes(firsts >> _ROW)] & ((np.uint64(1) << _ROW) - np.uint64(1))).astype(np.intp)
        weight[order[first]] = np.maximum(weight[order[first]], whole[of_box[first]])
    return replace(raw.votes, weight=weight).take(np.flatnonzero(weight))


def _fit(off: NDArray[np.uint8], sigma: float) -> Indices:
    """(N,) weights of votes the angles (N, 2) of which are off by so many ``FINE``ths of the circle.

    By a normal density, at least 1.
    """
    bell = np.exp(-0.5 * ((np.arange(FINE // 2 + 1) * (2.0 * np.pi / FINE)) / np.hypot(sigma, BENT)) ** 2)
    return np.asarray(np.maximum(1, np.rint(WHOLE * bell[off[:, 0]] * bell[off[:, 1]])).astype(np.intp))


def _changes(values: Indices | NDArray[np.uint64]) -> Mask:
    """(N,) whether each is another than the one before it."""
    return np.concatenate([np.ones(min(1, len(values)), bool), values[1:] != values[:-1]])


def _boxes(votes: Votes, places: Floats, size: Floats, offset: float) -> NDArray[np.uint64]:
    """(N,) a number for the box that each vote lies in: of one type, place, roll and size.

    It leaves room for ``_ROW`` bits.

    ``places`` (N, 2) pixels from the image's middle, which stays where it is when the camera is turned.
    """
    octave = np.floor(np.log(size) / SCALE + offset)
    wide = CELL * np.exp(octave * SCALE)
    column, row = (np.floor(places[:, axis] / wide + offset).astype(np.int64) % _SIDE for axis in (0, 1))
    turns = round(2.0 * np.pi / ROLL)
    turn = np.floor(np.mod(votes.roll, 2.0 * np.pi) / ROLL + offset).astype(np.int64) % turns
    key = (((votes.kind * _OCTAVES + octave.astype(np.int64) % _OCTAVES) * turns + turn) * _SIDE + column) * _SIDE + row
    return np.asarray(key).astype(np.uint64)
