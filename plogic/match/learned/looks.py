"""Which keypoints are of the right type for a feature at a pose (D8), and how rare that is where they are.

A keypoint looks right where its descriptor is like that of an appearance, and its size and its angle are what the pose
makes of that appearance.

* ``RightPairs``: N pairs of a feature and a keypoint that looks right, by whichever of its appearances
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.judged.evidence import clutter_density
from plogic.match.learned.agreement import ANGLES, SIZES
from plogic.match.learned.keypoints import farthest, spread

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex


LOOSER = 1.22
"""Descriptors may be this much farther apart where the pose says what to look for than where nothing is known."""
AROUND = 50.0
"""Pixels around a match within which clutter that looks right is counted."""
SAME = 10.0
"""Pixels around a match within which what looks right is the same thing, seen again at another point of its edge."""
TURNS, GROWTH = 0.14, 0.13
"""Standard deviations of a right keypoint's angle (radians) and of the logarithm of its size about what the pose makes
of its appearance; chosen on development scenes, as the next are."""
EVEN = 0.1
"""Share of what is right that is off by any angle, or any size, that may be right."""
POWER, RAREST = 6.0, 0.03
"""How the descriptors' distances of clutter that looks right are spread; the least ratio of it to what is right that is
believed."""
AS_RIGHT = 0.06
"""What looks no less right than a match by this share of the greatest distance counts as clutter beside it."""
BY_CHANCE = 0.06
"""Chance that a keypoint of clutter has the angle (0.6 rad either way of 2π) and the size (a factor of 1.6 either way)
that a pose demands."""


@dataclass(frozen=True)
class RightPairs:
    """``feature`` (N,), ``datum`` (N,).

    Of all M ways to look right, ``pair`` (M,) says which pair and ``lobe`` (M,) by which appearance.

    ``best`` (N,) is the appearance by which a pair looks most right; ``apart`` (N,) how far apart the descriptors are
    then, as a share of the farthest that look right; ``fit`` (N,) how much likelier such an angle and size are of what
    is right than of what merely may be.
    """

    feature: Indices
    datum: Indices
    pair: Indices
    lobe: Indices
    best: Indices
    apart: Floats
    fit: Floats

    def held(self, lobes: Indices) -> Mask:
        """(N,) whether a pair looks right by one of some lobes."""
        by = np.zeros(len(self.feature), bool)
        by[self.pair[np.isin(self.lobe, lobes)]] = True
        return by


def right_pairs(
    index: LearnedIndex,
    posed: Hypothesis,
    data: Data,
    lobes: Indices,
    features: Indices,
    free: Mask,
    reach: Floats | float,
) -> RightPairs:
    """Of some features (increasing) and keypoints that are ``free`` (A,), those that look right within ``reach`` pixels (one, or each its own).

    ``lobes`` (increasing) are those by which they may: a feature looks as it does from about this viewpoint
    (``lobes.lobes_about``).
    """
    first = np.searchsorted(index.cloud.feature[lobes], np.arange(len(index.points) + 1))
    some = np.diff(first)[features] > 0
    features, reach = features[some], np.broadcast_to(reach, len(some))[some]
    at = posed.at[index.cloud.feature[lobes]]
    size = np.log(index.cloud.size[lobes] * data.camera.f / np.maximum(at[:, 2], 1e-6))
    feature, datum = _within(posed.uv[features], reach, data, free)
    if len(
        feature
    ):  # of the right size for the smallest and the greatest of a feature's appearances, or for one between them
        least, most = (of_all.reduceat(size, first[features]) for of_all in (np.minimum, np.maximum))
        may = (data.sizes[datum] > least[feature] - SIZES) & (data.sizes[datum] < most[feature] + SIZES)
        feature, datum = feature[may], datum[may]
    feature = features[feature]
    count = np.diff(first)[feature]
    place = np.repeat(first[feature], count) + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    pair = np.repeat(np.arange(len(feature)), count)
    right, off, fit = _right(index, posed, data, lobes, size, place, datum[pair])
    order = np.lexsort((off, pair[right]))
    some, first, pair = np.unique(pair[right][order], return_index=True, return_inverse=True)
    ways = lobes[place[right]][order]
    return RightPairs(
        feature[some], datum[some], np.asarray(pair, np.intp), ways, ways[first], off[order][first], fit[order][first]
    )


def _within(places: Floats, reach: Floats, data: Data, free: Mask) -> tuple[Indices, Indices]:
    """All pairs of a place (F, 2) and a keypoint that is free at most its ``reach`` (F,) from it: indices of places, in order, and of data."""
    place, datum = data.keypoints.near(places, reach)
    right, down = (places[:, axis][place] - data.uv[:, axis][datum] for axis in (0, 1))
    near = (right * right + down * down <= reach[place] ** 2) & free[datum]
    return place[near], datum[near]


def _right(
    index: LearnedIndex, posed: Hypothesis, data: Data, lobes: Indices, size: Floats, place: Indices, datum: Indices
) -> tuple[Indices, Floats, Floats]:
    """Which of N pairs look right, how far apart, and their fit: of an appearance of this pose, ``place`` in ``lobes``, and a keypoint ``datum``.

    ``size`` (L,): logarithms of how large the appearances are in this pose, pixels.
    """
    turn = screen_angle(
        index.cloud.up[lobes] @ posed.camera_from_object[:3, :3].T, posed.at[index.cloud.feature[lobes]]
    )
    grown = size[place] - data.sizes[datum]
    right = np.flatnonzero(np.abs(grown) < SIZES)
    turned = wrapped(turn[place[right]] - data.angle[datum[right]])
    near = np.abs(turned) < ANGLES
    right, turned = right[near], turned[near]
    fit = _against_even(turned, TURNS, ANGLES) * _against_even(grown[right], GROWTH, SIZES)
    width = min(index.cloud.descriptor.shape[1], data.descriptors.shape[1])
    mine, its = (
        spread(some[:, :width])
        for some in (index.cloud.descriptor[lobes[place[right]]], data.descriptors[datum[right]])
    )
    mine -= its
    off = np.sqrt(np.einsum("ij,ij->i", mine, mine).astype(float)) / (
        LOOSER * farthest(mine)
    )  # sums of bytes squared, exact in single precision
    return right[off < 1.0], off[off < 1.0], fit[off < 1.0]


def _against_even(off: Floats, sigma: float, most: float) -> Floats:
    """How much likelier it is to be ``off`` (N,) by chance of measurement than evenly anywhere up to ``most``.

    ``EVEN`` of what is right is even.
    """
    return np.asarray(
        (1.0 - EVEN) * np.exp(-0.5 * (off / sigma) ** 2) / (np.sqrt(2.0 * np.pi) * sigma) * 2.0 * most + EVEN
    )


def likeness(
    index: LearnedIndex, posed: Hypothesis, lobes: Indices, matches: Indices, data: Data, kb: KnowledgeBase
) -> Floats:
    """(F,) of each match, how much rarer a keypoint that looks as right is there than clutter of its word is in an image; 1 where unmatched.

    Clutter that happens to look right seldom looks quite right: the share of it within a distance a of the descriptors
    (of the greatest, 1) grows as a^``POWER``, that of what is right about evenly; unless the image holds more that
    looks as right, by its ``lexicon``. And print is full of keypoints of one angle and size that look alike: so what
    would look as right were it in place is counted, within ``AROUND`` pixels.
    """
    result = np.ones(len(matches))
    found = np.flatnonzero(matches >= 0)
    if len(found):
        wide = right_pairs(index, posed, data, lobes, found, data.described, AROUND)
        apart = np.linalg.norm(data.uv[wide.datum] - data.uv[matches[wide.feature]], axis=1)
        match = wide.datum == matches[wide.feature]
        how, fit, rare = np.ones((3, len(matches)))
        how[wide.feature[match]], fit[wide.feature[match]] = wide.apart[match], wide.fit[match]
        as_far = LOOSER * (wide.apart[match] + AS_RIGHT)
        of_all = index.lexicon.as_right(index.object_type.name, data, wide.best[match], wide.datum[match], as_far, SAME)
        rare[wide.feature[match]] = np.clip(of_all, RAREST, 1.0)
        as_right = (apart > SAME) & (wide.apart <= how[wide.feature] + AS_RIGHT)
        others = np.bincount(wide.feature[as_right], minlength=len(matches))[found]
        usual = clutter_density(kb, data, matches[found])
        chance = BY_CHANCE * np.maximum(POWER * how[found] ** (POWER - 1.0), rare[found])
        here = np.maximum(usual, data.namesakes[matches[found]] / float(data.camera.width * data.camera.height))
        result[found] = fit[found] * usual / (others / (np.pi * AROUND**2) + chance * here)
    return result
