"""Which keypoints of Γ look like which appearances of a type: by their descriptors alone.

* ``Pairs``: P of them, ``datum`` (P,), ``lobe`` (P,), ``weight`` (P,)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.learned.lexicon import NTH
from sensing.detectors.edge_sides import fairly

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_index import LearnedIndex

EACH = 3
"""Features that a keypoint is paired with, the most alike."""
CLOSE, OFF = 120.0, 100.0
"""Descriptors no farther apart are as good as equal; of those farther apart fewer are right, by a bell of this
width."""
MOST, SEEDS = 2500, 400
"""Pairs in all; those of them that poses are made of."""
CELL = 64.0
"""Pixels: half of the pairs are taken in turns from cells of the image this wide, so that no textured floor drowns an
object."""


@dataclass(frozen=True)
class Pairs:
    """P keypoints and appearances that look alike: half of them the weightiest, half of them the weightiest of each part of the image.

    ``weight`` (P,) in (0, 1], about as the odds that a pair is right: 1 for the keypoint of the image that looks most
    like the appearance, a third for the second, and so on. What looks like much else in the image says little: a corner
    of a letter is anywhere in print.
    """

    datum: NDArray[np.intp]
    lobe: NDArray[np.intp]
    weight: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.datum)

    def first(self, count: int) -> Pairs:
        """The first of them, again half and half."""
        return Pairs(self.datum[:count], self.lobe[:count], self.weight[:count])


def pairs_of(index: LearnedIndex, data: Data) -> Pairs:
    """At most ``EACH`` features a keypoint, by their most similar appearance, and ``MOST`` pairs."""
    datum, lobe, apart = index.lexicon.alike(index.object_type.name, data)
    place = np.arange(len(lobe)) - np.searchsorted(lobe, lobe)
    near = place < NTH
    datum, lobe, apart, place = datum[near], lobe[near], apart[near], place[near]
    weight = np.exp(-0.5 * (np.maximum(apart - CLOSE, 0.0) / OFF) ** 2) / (1.0 + place) ** 1.5
    feature = index.cloud.feature[lobe]
    keep = np.lexsort((datum, -weight))  # of one datum by appearance, for so they come
    keep = _leading(keep, datum * len(index.points) + feature, 1)
    keep = _leading(keep, datum, EACH)
    best = keep[fairly(data.uv[datum[keep]], CELL)[:MOST]]
    return Pairs(datum[best], lobe[best], weight[best])


def _leading(order: NDArray[np.intp], owner: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Of pairs in some order the first few of each owner, in that order."""
    owners = owner[order]
    by_owner = np.argsort(owners, kind="stable")
    place = np.arange(len(order)) - np.searchsorted(owners[by_owner], owners[by_owner])
    return order[np.sort(by_owner[place < most])]
