"""Expected and Detected of a learned type at a pose (D7, D8).

What its measured lobes say, and which keypoint each feature takes.

Its own body hides nothing more: the lobes were measured on it. A keypoint looks right where its descriptor is like that
of an appearance, and its size and its angle are what the pose makes of that appearance; how rare that is where it is,
``likeness`` says.

* ``RightPairs``: N pairs of a feature and a keypoint that looks right, by whichever of its appearances
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import transform_points
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.judged.evidence import clutter_density
from plogic.match.judged.expectation import FEWEST, assigned
from plogic.match.learned.agreement import ANGLES, SIZES, lobes_about, lobes_held
from plogic.match.learned.keypoints import farthest, spread
from plogic.match.learned.sides import side_likeness, side_matches

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
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
    """Of some features (increasing) and ``free`` keypoints (A,), those that look right within ``reach`` pixels.

    ``reach`` is one, or each its own.

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
    """All pairs of a place (F, 2) and a keypoint that is free at most its ``reach`` (F,) from it.

    Indices of places, in order, and of data.
    """
    place, datum = data.keypoints.near(places, reach)
    right, down = (places[:, axis][place] - data.uv[:, axis][datum] for axis in (0, 1))
    near = (right * right + down * down <= reach[place] ** 2) & free[datum]
    return place[near], datum[near]


def _right(
    index: LearnedIndex, posed: Hypothesis, data: Data, lobes: Indices, size: Floats, place: Indices, datum: Indices
) -> tuple[Indices, Floats, Floats]:
    """Which of N pairs look right, how far apart, and their fit.

    Of an appearance of this pose, ``place`` in ``lobes``, and a keypoint ``datum``.

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
    """(F,) how much rarer an equally right keypoint is at each match than clutter of its word; 1 where unmatched.

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


ROBUST = 1.5
MEDIAN, MEDIAN_ACROSS = 1.177, 0.6745
"""Median of the distance of two normal errors of σ = 1, and of the size of one."""
SIDES_NOISE = 0.6
"""Least location noise of sides across their edge: where a body is round its outline is not quite where it was
learned."""
SIDES_REACH = (3.0, 6.0)
"""Bounds of how far off across its edge a side is looked for, pixels."""
WIDE = 2.5
"""Standard deviations of a feature's place within which its keypoint is looked for, where that is farther than the
tolerance."""
NOISE = (0.3, 2.0)
"""Bounds of the location noise, pixels."""


def pose_of(index: LearnedIndex, pose: Floats, data: Data, kb: KnowledgeBase) -> Hypothesis:
    """What geometry says of the type at a pose; nothing is matched yet."""
    camera, cloud = data.camera, index.cloud
    at = transform_points(pose, index.points)
    uv, count = camera.project(at), len(at)
    held = lobes_held(index, pose, camera.f / kb.f_ref)
    if not data.whole.sided.any():  # no colours, or detected by others: sides are not looked for, and not missed
        held = held[~cloud.sided[held]]
    best = held[np.lexsort((cloud.hit[held], cloud.feature[held]))]  # the greatest rate of each feature comes last
    feature, (hit, turn) = cloud.feature[best], np.zeros((2, count))
    hit[feature], turn[feature] = cloud.hit[best], screen_angle(cloud.up[best] @ pose[:3, :3].T, at[feature])
    return Hypothesis(
        type=index.object_type.name,
        camera_from_object=pose,
        opaque=index.object_type.opaque,
        known_type=index.object_type,
        at=at,
        uv=uv,
        in_image=camera.contains(uv),
        in_lobe=np.bincount(cloud.feature[held], minlength=count) > 0,
        self_hidden=np.zeros(count, bool),
        right=np.zeros((count, 0), bool),
        matches=np.full(count, -1, np.intp),
        residual=np.full(count, np.nan),
        hit=hit,
        turn=turn,
        sided=index.sided,
    )


def matched(
    index: LearnedIndex,
    posed: Hypothesis,
    data: Data,
    kb: KnowledgeBase,
    free: Mask | None = None,
    hidden: Mask | None = None,
) -> Hypothesis:
    """The hypothesis' one assignment (D8): expected features first, then unexpected ones.

    One keypoint a feature, one feature a keypoint.

    Sides of edges are looked for where they are expected alone: edges are everywhere, and those of a hidden feature
    would be found by chance.
    """
    expected = posed.expected(hidden)
    described = data.described if free is None else data.described & free
    about = lobes_about(index, posed.camera_from_object)
    features, tolerance = np.flatnonzero(posed.in_image & ~index.sided), kb.rates.match_tolerance
    spread = index.cloud.sigma * data.camera.f / np.maximum(posed.at[:, 2], 1e-6)
    reach = np.maximum(tolerance, WIDE * spread)  # the middle of a region is not as exact as a corner
    near = right_pairs(index, posed, data, about, features, described, reach[features])
    lobes = lobes_held(index, posed.camera_from_object, data.camera.f / kb.f_ref)
    feature, datum, held = near.feature, near.datum, near.held(lobes)
    off = np.linalg.norm(posed.uv[feature] - data.uv[datum], axis=1) * (tolerance / reach[feature])
    matches = np.full(len(posed.uv), -1, np.intp)
    awaited = expected[feature] & held
    assigned(matches, feature[awaited], datum[awaited], off[awaited], tolerance)
    left = ~np.isin(datum, matches[matches >= 0]) & ~expected[feature]
    assigned(matches, feature[left], datum[left], off[left], tolerance)
    residual = (
        np.where(matches >= 0, np.linalg.norm(posed.uv - data.uv[np.maximum(matches, 0)], axis=1), np.nan)
        if len(data.ids)
        else posed.residual
    )
    sigma = np.hypot(blur(residual[(expected & (matches >= 0)) & (reach <= tolerance)]), spread)
    like = likeness(index, posed, about, matches, data, kb)
    posed = replace(
        posed,
        matches=matches,
        residual=residual,
        sigma=sigma,
        likeness=like,
        across=np.full((len(posed.uv), 2), np.nan),
    )
    sided = lobes[index.cloud.sided[lobes] & expected[index.cloud.feature[lobes]]]
    return (
        _with_sides(index, posed, data, kb, sided, data.sided if free is None else data.sided & free)
        if len(sided)
        else posed
    )


def _with_sides(
    index: LearnedIndex,
    posed: Hypothesis,
    data: Data,
    kb: KnowledgeBase,
    lobes: Indices,
    free: Mask,
) -> Hypothesis:
    """What is matched so far, and the sides of edges that are those of ``lobes``, which are expected.

    Of data that are ``free`` (A,).
    """
    spread = index.cloud.sigma * data.camera.f / np.maximum(posed.at[:, 2], 1e-6)
    found = side_matches(index, posed, data, lobes, free, np.clip(WIDE * spread, *SIDES_REACH))
    names = "matches", "residual", "sigma", "likeness", "across"
    matches, residual, sigma, like, across = (np.array(getattr(posed, name)) for name in names)
    matches[found.feature], residual[found.feature], across[found.feature] = (
        found.datum,
        np.abs(found.off),
        found.across,
    )
    sigma[index.sided] = np.hypot(blur(np.abs(found.off), MEDIAN_ACROSS, SIDES_NOISE), spread[index.sided])
    like[found.feature] = side_likeness(found, sigma[found.feature], data, kb)
    return replace(posed, matches=matches, residual=residual, sigma=sigma, likeness=like, across=across)


def precision(posed: Hypothesis) -> Floats:
    """(F,) 1/pixel² of each match's place, as much as it is counted.

    What lies far off for this noise is likely another's.
    """
    assert posed.sigma is not None  # noqa: S101 - of a learned type it was measured
    return np.nan_to_num(posed.counted / (posed.sigma**2 + 0.25 * posed.residual**2))


def blur(residual: Floats, median: float = MEDIAN, least: float = NOISE[0]) -> float:
    """Location noise of this instance in this image, pixels, by the median of its matches' residuals (N,).

    Sharp where the image is sharp.

    ``median`` is that of residuals of noise of σ = 1; there is never less noise than ``least``.

    A pose that is wrong but near has worse residuals than the right one, which only their own scale tells.
    """
    return float(np.clip(np.median(residual) / median, least, NOISE[1])) if len(residual) >= FEWEST else NOISE[1]
