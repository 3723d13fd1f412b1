"""Which keypoints of Γ look like which appearances of a type: by their descriptors alone.

* ``Pairs``: P of them, ``datum`` (P,), ``lobe`` (P,), ``apart`` (P,) the distance of the descriptors
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex

ALIKE = {128: 300.0, 256: 8.5}
"""Farthest descriptors of a pair, by their length as vectors: of SIFT, and of ORB's bits (72 of them)."""
EACH = 3
"""Features that a keypoint is paired with, the most alike."""
NTH = 15
"""Keypoints that an appearance is paired with, the most alike: of more, each would count an eighth at most."""
MOST, SEEDS = 2500, 700
"""Pairs in all, the weightiest; those of them that poses are made of."""
_BLOCK = 1024


@dataclass(frozen=True)
class Pairs:
    """P keypoints and appearances that look alike, the weightiest first.

    ``weight`` (P,) in (0, 1]: 1 for the keypoint of the image that looks most like the appearance, half for the third, and so on. What
    looks like much else in the image says little: a corner of a letter is anywhere in print.
    """

    datum: NDArray[np.intp]
    lobe: NDArray[np.intp]
    apart: NDArray[np.float64]
    weight: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.datum)

    def first(self, count: int) -> Pairs:
        """The weightiest."""
        return Pairs(self.datum[:count], self.lobe[:count], self.apart[:count], self.weight[:count])


def spread(descriptors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(N, D) as vectors whose distance is Euclid's (SIFT) or the root of Hamming's (ORB)."""
    return np.unpackbits(descriptors, axis=1).astype(np.float32) if descriptors.shape[1] == 32 else descriptors.astype(np.float32)


def pairs_of(index: LearntIndex, data: Data) -> Pairs:
    """At most ``EACH`` features a keypoint, by their most similar appearance, and ``MOST`` pairs."""
    described = np.flatnonzero(data.described)
    if not len(described) or not len(index.squares):
        return Pairs(np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0), np.zeros(0))
    some = spread(data.descriptors[described])
    limit = ALIKE[some.shape[1]]
    rows, lobes, squares = [], [], []
    for start in range(0, len(some), _BLOCK):
        block = some[start : start + _BLOCK]
        apart = block @ index.descriptors.T
        apart *= -2.0
        apart += index.squares
        near, lobe = np.nonzero(apart < (limit**2 - (block**2).sum(axis=1))[:, None])
        rows.append(near + start)
        lobes.append(lobe)
        squares.append(apart[near, lobe] + (block[near] ** 2).sum(axis=1))
    row, lobe = np.concatenate(rows), np.concatenate(lobes)
    distance = np.sqrt(np.maximum(np.concatenate(squares), 0.0)).astype(np.float64) * (ALIKE[128] / limit)
    return _best(index, described[row], lobe, distance)


def _best(index: LearntIndex, datum: NDArray[np.intp], lobe: NDArray[np.intp], apart: NDArray[np.float64]) -> Pairs:
    order = np.argsort(lobe + apart / (2.0 * ALIKE[128]), kind="stable")
    starts = np.searchsorted(lobe[order], np.arange(len(index.squares)))
    place = np.arange(len(lobe)) - starts[lobe[order]]
    order, place = order[place < NTH], place[place < NTH]
    datum, lobe, apart = datum[order], lobe[order], apart[order]
    weight = np.exp(-0.5 * (apart / ALIKE[128]) ** 2) / (1.0 + 0.5 * place)
    feature = index.cloud.feature[lobe]
    keep = _leading(np.lexsort((lobe, -weight, feature, datum)), datum * len(index.points) + feature, 1)
    keep = _leading(keep[np.lexsort((lobe[keep], -weight[keep], datum[keep]))], datum, EACH)
    best = keep[np.lexsort((lobe[keep], datum[keep], -weight[keep]))[:MOST]]
    return Pairs(datum[best], lobe[best], apart[best], weight[best])


def _leading(order: NDArray[np.intp], owner: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Of pairs ordered by their owners, the first few of each owner."""
    owners = owner[order]
    return order[np.arange(len(order)) - np.searchsorted(owners, owners) < most]
