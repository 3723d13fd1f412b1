"""Which keypoints are of the right type for a feature at a pose (D8), and how rare that is where they are.

A keypoint looks right where its descriptor is like that of an appearance, and its size and its angle are what the pose makes of that
appearance.

* ``RightPairs``: N pairs of a feature and a keypoint that looks right, by whichever of its appearances
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse
from plogic.evidence import clutter_density
from plogic.search.learnt.agreement import ANGLES, ASIDE, GRAZING, SIZES, screen_angle
from plogic.search.learnt.lexicon import FARTHEST, spread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase
    from plogic.expectation import Posed
    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

LOOSER = 1.22
"""Descriptors may be this much farther apart where the pose says what to look for than where nothing is known."""
AROUND = 50.0
"""Pixels around a match within which clutter that looks right is counted."""
SAME = 10.0
"""Pixels around a match within which what looks right is the same thing, seen again at another point of its edge."""
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


def right_pairs(
    index: LearntIndex, posed: Posed, data: Data, lobes: Indices, features: Indices, free: NDArray[np.bool_], reach: float
) -> RightPairs:
    """Of some features (increasing) and the keypoints that are ``free`` (A,), those within ``reach`` pixels of where the feature is that look right.

    ``lobes`` (increasing) are those by which they may: a feature looks as it does from about this viewpoint (``lobes_about``).
    """
    first = np.searchsorted(index.cloud.feature[lobes], np.arange(len(index.points) + 1))
    features = features[np.diff(first)[features] > 0]
    found = data.tree.query_ball_point(posed.uv[features], reach, return_sorted=True) if len(features) else []
    feature = np.repeat(features, [len(some) for some in found])
    datum = np.fromiter(chain.from_iterable(found), np.intp)
    some = free[datum]
    feature, datum = feature[some], datum[some]
    count = np.diff(first)[feature]
    place = np.repeat(first[feature], count) + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    pair = np.repeat(np.arange(len(feature)), count)
    right = _right(index, posed, data, lobes, place, datum[pair])
    some, pair = np.unique(pair[right], return_inverse=True)
    return RightPairs(feature[some], datum[some], np.asarray(pair, np.intp), lobes[place[right]])


def lobes_about(index: LearntIndex, pose: Floats) -> Indices:
    """Indices of the lobes that hold the viewpoint, or would if they were wider by ``ASIDE``."""
    line = inverse(pose)[:3, 3] - index.places
    wide = np.cos(np.minimum(index.cloud.half_angle + ASIDE, GRAZING))
    return np.flatnonzero((line * index.cloud.axis).sum(axis=1) >= wide * np.linalg.norm(line, axis=1))


def _right(index: LearntIndex, posed: Posed, data: Data, lobes: Indices, place: Indices, datum: Indices) -> Indices:
    """Which of N pairs look right: of an appearance of this pose, ``place`` (N,) in ``lobes``, and a keypoint ``datum`` (N,)."""
    at = posed.at[index.cloud.feature[lobes]]
    size = np.log(index.cloud.size[lobes] * data.camera.f / np.maximum(at[:, 2], 1e-6))
    turn = screen_angle(index.cloud.up[lobes] @ posed.camera_from_object[:3, :3].T, at)
    right = np.flatnonzero(np.abs(size[place] - np.log(data.scale[datum])) < SIZES)
    turned = turn[place[right]] - data.angle[datum[right]]
    right = right[np.abs((turned + np.pi) % (2.0 * np.pi) - np.pi) < ANGLES]
    mine, its = (spread(some) for some in (index.cloud.descriptor[lobes[place[right]]], data.descriptors[datum[right]]))
    return np.asarray(right[((mine - its) ** 2).sum(axis=1) < (LOOSER * FARTHEST[mine.shape[1]]) ** 2])


def likeness(index: LearntIndex, posed: Posed, lobes: Indices, matches: Indices, data: Data, kb: KnowledgeBase) -> Floats:
    """(F,) of each match, how much rarer a keypoint that looks right is there than clutter of its word is in an image; 1 where unmatched.

    Print is full of keypoints of one angle and size that look alike. What clutter is there is therefore counted there: the keypoints that
    would be right were they in place, within ``AROUND`` pixels, besides those expected of any image.
    """
    result = np.ones(len(matches))
    found = np.flatnonzero(matches >= 0)
    if len(found):
        wide = right_pairs(index, posed, data, lobes, found, data.described, AROUND)
        apart = np.linalg.norm(data.uv[wide.datum] - data.uv[matches[wide.feature]], axis=1)
        others = np.bincount(wide.feature[apart > SAME], minlength=len(matches))[found]
        usual = clutter_density(kb, data, matches[found])
        result[found] = usual / (others / (np.pi * AROUND**2) + BY_CHANCE * usual)
    return result
