"""Hypotheses of a type from Γ (§6.3, §7).

Pairs in view cells, votes, sets of four, POSIT, refinement, and only then rays.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.poses.refine import refined_poses
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Data, project_ideal
from plogic.match.hand.correspondences import Pairs, linked_pairs, open_pairs, votes
from plogic.match.hand.extend import Candidates, coarse_poses, extend, firsts
from plogic.match.hand.triples import image_triples, triple_poses
from plogic.match.hand.view_cells import DistanceMaps, best_apart, distance_maps, pose_votes
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import matched, pose_of
from plogic.match.judged.rivals import distinct, distinct_poses

if TYPE_CHECKING:
    from collections.abc import Callable

    from geometry.arrays import Floats, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.hand.hand_models import TypeIndex

VOTED = 2000
"""Coarse poses of each kind that all features vote on: the best by the votes of the anchors."""
REFINED = 110
"""Coarse poses that are refined, the best by votes and no two alike."""
ROBUST = 0.25
"""Pixels beyond which a match weighs less in the last refinement: a wrong match within the tolerance must not pull the
pose."""
VERIFIED = 12
"""Refined poses that rays are cast for."""


def generate(
    index: TypeIndex,
    data: Data,
    kb: KnowledgeBase,
    covered: Mask | None = None,
    *,
    refined: int = REFINED,
    verified: int = VERIFIED,
    check: Callable[[], None] = unhurried,
) -> list[tuple[float, Hypothesis]]:
    """The best distinct poses of one type as (log-likelihood ratio against clutter, hypothesis), best first.

    ``covered`` (H, W): where accepted opaque objects stand in the ideal image. ``refined``, ``verified``: how many
    poses go that far. ``check`` is called between stages, and between blocks of what grows with Γ, and may raise to end
    the search.
    """
    check()
    allowed = index.allowed(data)
    if len(data.ids) < 4 or len(index.points) < 4 or not allowed.any():
        return []
    maps = distance_maps(allowed, data, covered, check)
    poses = np.concatenate(
        [_from_pairs(index, allowed, maps, data, check), _from_triples(index, allowed, maps, data, check)]
    )
    check()
    if not len(poses):
        return []
    worth = pose_votes(poses, index.cells, index.points, index.weights, maps, data)
    check()
    kept = poses[best_apart(worth, poses, index.cells, data, refined)]
    found = extend(kept, index.cells, index.points, index.weights, maps, data, kb.rates.match_tolerance)
    check()
    return _verified(found, index, allowed, maps, data, kb, verified, check)


def _from_pairs(index: TypeIndex, allowed: Mask, maps: DistanceMaps, data: Data, check: Callable[[], None]) -> Floats:
    """(N, 4, 4) the poses of those pairs that the anchors vote for most."""
    coarse = _pairs(index, allowed, maps, data, check)
    check()
    worth = votes(coarse, index.cells, maps, index.weights, data, index.anchors)
    return coarse_poses(coarse.take(np.sort(np.argsort(-worth, kind="stable")[:VOTED])), index.cells, data)


def _from_triples(index: TypeIndex, allowed: Mask, maps: DistanceMaps, data: Data, check: Callable[[], None]) -> Floats:
    """(N, 4, 4) the poses of those triples that the anchors and some of the other features vote for most."""
    members = np.flatnonzero(allowed[index.triples.features.ravel()].any(axis=0))
    if len(members) < 3:
        return np.zeros((0, 4, 4))
    poses = triple_poses(
        index.triples, image_triples(data, members, check), index.points, _scales(index, data), data.camera.f
    )
    check()
    others = np.setdiff1d(np.arange(len(index.points)), index.anchors)[::4]
    worth = pose_votes(
        poses, index.cells, index.points, index.weights, maps, data, np.concatenate([index.anchors, others])
    )
    return poses[np.sort(np.argsort(-worth, kind="stable")[:VOTED])]


def _pairs(index: TypeIndex, allowed: Mask, maps: DistanceMaps, data: Data, check: Callable[[], None]) -> Pairs:
    """Pairs by the junctions' arms where the detector gave arms, by places alone where it gave none."""
    anchored = np.asarray(allowed[index.anchors].any(axis=0))
    some, columns = data.only(anchored), np.flatnonzero(anchored)
    edged = index.cells.arms.shape[2] > 0 and bool(np.isfinite(some.arms).any()) and len(index.links) > 0
    own = allowed[:, columns], some, _scales(index, data)
    found = (
        linked_pairs(index.cells, index.links, *own, check)
        if edged
        else open_pairs(index.cells, index.anchors, *own, maps, check)
    )
    return replace(found, datum=columns[found.datum], other_datum=columns[found.other_datum])


def _scales(index: TypeIndex, data: Data) -> tuple[float, float]:
    """Plausible pixels a metre: the object from 12 pixels to twice the image's height."""
    return 12.0 / index.cells.diameter, 2.0 * data.camera.height / index.cells.diameter


def _verified(
    found: Candidates,
    index: TypeIndex,
    allowed: Mask,
    maps: DistanceMaps,
    data: Data,
    kb: KnowledgeBase,
    most: int,
    check: Callable[[], None],
) -> list[tuple[float, Hypothesis]]:
    """Cast rays for the best refined poses, match, polish once, and keep one of each heap of near-duplicates."""
    fitted = (
        pose for pose in found.camera_from_object[found.fitted] if _plausible(pose, index)
    )  # they come best first
    first = []
    for pose in distinct_poses(index.object_type, fitted, most):
        check()
        first.append(_matched_at(index, pose, allowed, maps, data, kb))
    scored = []
    for posed, hidden in _polished(index, first, allowed, maps, data, kb, check):
        check()
        scored.append((evidence(posed, data, kb, hidden).ratio, posed))
    return distinct(scored, index.object_type)


def _matched_at(
    index: TypeIndex,
    pose: Floats,
    allowed: Mask,
    maps: DistanceMaps,
    data: Data,
    kb: KnowledgeBase,
) -> tuple[Hypothesis, Mask]:
    """The hypothesis at a pose, matched, and its features (F,) that accepted objects cover."""
    posed = pose_of(index.object_type, pose, data, kb)
    hidden = maps.is_covered(project_ideal(pose[None], index.points, data)[0])
    return matched(posed, data, allowed, kb.rates.match_tolerance, hidden=hidden), hidden


def _polished(
    index: TypeIndex,
    found: list[tuple[Hypothesis, Mask]],
    allowed: Mask,
    maps: DistanceMaps,
    data: Data,
    kb: KnowledgeBase,
    check: Callable[[], None],
) -> list[tuple[Hypothesis, Mask]]:
    """All refined in one batch and matched again; those with fewer than four expected features detected are dropped."""
    used = np.array([p.expected(hidden) & p.detected for p, hidden in found]).reshape(len(found), len(index.points))
    some = np.flatnonzero(used.sum(axis=1) >= 4)
    if not len(some):
        return []
    poses = np.array([found[i][0].camera_from_object for i in some])
    first, matches = firsts(used[some]), np.array([np.maximum(found[i][0].matches, 0) for i in some])
    weights = np.take_along_axis(used[some] * index.precision(kb.rates), first, axis=1)
    uv = data.uv[np.take_along_axis(matches, first, axis=1)]
    better = refined_poses(poses, index.points[first], uv, weights, data.camera, huber=ROBUST)
    again = []
    for pose in better:
        check()
        again.append(_matched_at(index, pose, allowed, maps, data, kb))
    return again


def _plausible(pose: Floats, index: TypeIndex) -> bool:
    """Finite and wholly in front of the camera."""
    centre = pose[:3, :3] @ index.cells.centre + pose[:3, 3]
    return bool(np.isfinite(pose).all() and centre[2] > 0.5 * index.cells.diameter)
