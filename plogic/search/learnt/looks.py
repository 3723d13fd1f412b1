"""Which keypoints are of the right type for a feature at a pose (D8), and how rare that is where they are.

A keypoint looks right where its descriptor is like that of an appearance, and its size and its angle are what the pose makes of that
appearance.

* ``RightPairs``: N pairs of a feature and a keypoint that looks right, by whichever of its appearances
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.evidence import clutter_density
from plogic.search.learnt.agreement import ANGLES, SIZES, screen_angle
from plogic.search.learnt.pairs import ALIKE, spread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.expectation import Posed
    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

LOOSER = 1.1
"""Descriptors may be this much farther apart where the pose says what to look for than where nothing is known."""
AROUND = 50.0
"""Pixels around a match within which clutter that looks right is counted."""
BY_CHANCE = 0.06
"""Chance that a keypoint of clutter has the angle (0.6 rad either way of 2π) and the size (a factor of 1.6 either way) that a pose demands."""


@dataclass(frozen=True)
class RightPairs:
    """``feature`` (N,), ``datum`` (N,); of all M ways to look right, ``pair`` (M,) says which pair and ``lobe`` (M,) by which appearance."""

    feature: Indices
    datum: Indices
    pair: Indices
    lobe: Indices

    def held(self, lobes: Indices) -> NDArray[np.bool_]:
        """(N,) whether a pair looks right by one of some lobes."""
        by = np.zeros(len(self.feature), bool)
        by[self.pair[np.isin(self.lobe, lobes)]] = True
        return by


def right_pairs(index: LearntIndex, posed: Posed, data: Data, features: Indices, described: Indices, reach: float) -> RightPairs:
    """Of some features and some keypoints (both increasing), those within ``reach`` pixels of where the feature is that look right."""
    from scipy.spatial import cKDTree

    nothing = np.zeros(0, np.intp)
    if not len(features) or not len(described):
        return RightPairs(nothing, nothing, nothing, nothing)
    found = cKDTree(data.uv[described]).query_ball_point(posed.uv[features], reach, return_sorted=True)
    feature = np.repeat(features, [len(some) for some in found])
    datum = described[np.concatenate([np.asarray(some, np.intp) for some in found])]
    count = np.diff(index.first)[feature]
    lobe = np.repeat(index.first[feature], count) + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    pair = np.repeat(np.arange(len(feature)), count)
    right = _right(index, posed, data, lobe, datum[pair])
    some, pair = np.unique(pair[right], return_inverse=True)
    return RightPairs(feature[some], datum[some], np.asarray(pair, np.intp), lobe[right])


def _right(index: LearntIndex, posed: Posed, data: Data, lobe: Indices, datum: Indices) -> NDArray[np.bool_]:
    """(N,) whether a keypoint looks as an appearance would at this pose."""
    at = posed.at[index.cloud.feature[lobe]]
    size = index.cloud.size[lobe] * data.camera.f / np.maximum(at[:, 2], 1e-6)
    right = np.abs(np.log(size / data.scale[datum])) < SIZES
    turned = screen_angle(index.cloud.up[lobe] @ posed.camera_from_object[:3, :3].T, at) - data.angle[datum]
    right &= np.abs((turned + np.pi) % (2.0 * np.pi) - np.pi) < ANGLES
    some = np.flatnonzero(right)
    if len(some):
        mine = index.descriptors[lobe[some]]
        right[some] = np.linalg.norm(mine - spread(data.descriptors[datum[some]]), axis=1) < LOOSER * ALIKE[mine.shape[1]]
    return np.asarray(right)


def likeness(index: LearntIndex, posed: Posed, matches: Indices, data: Data, kb: KnowledgeBase) -> Floats:
    """(F,) of each match, how much rarer a keypoint that looks right is there than clutter of its word is in an image; 1 where unmatched.

    Print is full of keypoints of one angle and size that look alike. What clutter is there is therefore counted there: the keypoints that
    would be right were they in place, within ``AROUND`` pixels, besides those expected of any image.
    """
    result = np.ones(len(matches))
    found = np.flatnonzero(matches >= 0)
    if len(found):
        wide = right_pairs(index, posed, data, found, np.flatnonzero(data.described), AROUND)
        others = np.bincount(wide.feature[wide.datum != matches[wide.feature]], minlength=len(matches))[found]
        usual = clutter_density(kb, data)[matches[found]]
        result[found] = usual / (others / (np.pi * AROUND**2) + BY_CHANCE * usual)
    return result
