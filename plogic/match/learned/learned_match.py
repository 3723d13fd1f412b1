"""Expected and Detected of a learned type at a pose (D7, D8): what its measured lobes say, and which keypoint each feature takes.

Its own body hides nothing more: the lobes were measured on it. Which keypoints are of the right type, ``looks`` says.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import transform_points
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.grid import screen_angle
from plogic.match.judged.expectation import FEWEST, assigned
from plogic.match.learned.agreement import lobes_about, lobes_held
from plogic.match.learned.looks import likeness, right_pairs
from plogic.match.learned.sides import side_likeness, side_matches

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex


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
    """Location noise of this instance in this image, pixels, by the median of its matches' residuals (N,): sharp where the image is sharp.

    ``median`` is that of residuals of noise of σ = 1; there is never less noise than ``least``.

    A pose that is wrong but near has worse residuals than the right one, which only their own scale tells.
    """
    return float(np.clip(np.median(residual) / median, least, NOISE[1])) if len(residual) >= FEWEST else NOISE[1]
