"""Hypotheses of one type from Γ (§6.3, §7): pairs in view cells, votes, sets of four, POSIT, refinement, and only then rays.

Vocabulary: ``TypeIndex``, what is computed once a type: its view cells, its features' places and dv.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import pose_error
from geometry.refine import refine_poses
from plogic.evidence import evidence
from plogic.expectation import matched, pose_of
from plogic.measures.valuation import compatible
from plogic.search.extend import Posed as Candidates
from plogic.search.extend import coarse_poses, extend
from plogic.search.links import feature_links, linked_pairs
from plogic.search.open_pairs import open_pairs
from plogic.search.pairs import MOST_PAIRS
from plogic.search.pose_votes import best_apart, pose_votes
from plogic.search.projection import project_ideal
from plogic.search.symmetry import permutations, unique_sets
from plogic.search.triples import PlaneTriples, image_triples, plane_triples, triple_poses
from plogic.search.view_cells import ViewCells, view_cells
from plogic.search.votes import DistanceMaps, distance_maps, votes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.cloud import KnowledgeBase, ObjectType
    from plogic.expectation import Posed
    from plogic.search.data import Data
    from plogic.search.pairs import Pairs

ANCHORS = 16
"""Features that seeds and pairs are made of: the most distinctive ones."""
VOTED = 2000
"""Coarse poses of each kind that all features vote on: the best by the votes of the anchors."""
REFINED = 110
"""Coarse poses that are refined, the best by votes and no two alike."""
ROBUST = 0.25
"""Pixels beyond which a match weighs less in the last refinement: a wrong match within the tolerance must not pull the pose."""
VERIFIED = 12
"""Refined poses that rays are cast for."""
SAME_ROTATION, SAME_PLACE = np.radians(6.0), 0.06
"""Two poses of a type nearer than this (radians; share of the distance) are one hypothesis (§8)."""


@dataclass(frozen=True)
class TypeIndex:
    """One type made ready for search.

    ``points`` (F, 3) metres; ``weights`` (F,) dv; ``anchors`` feature indices, the most distinctive; ``links`` (N, 2) joined by edges;
    ``triples`` of neighbours on planes.
    """

    object_type: ObjectType
    cells: ViewCells
    points: NDArray[np.float64]
    weights: NDArray[np.float64]
    anchors: NDArray[np.intp]
    links: NDArray[np.intp]
    triples: PlaneTriples

    def allowed(self, data: Data) -> NDArray[np.bool_]:
        """(F, A) the data of a type that the feature has in any of its lobes."""
        types = [frozenset(a.type for a in feature.appearances) for feature in self.object_type.features]
        return compatible(types, data.types)

    @property
    def significant(self) -> float:
        """What the log-likelihood ratio beyond what fixes a pose must exceed: the best of so many tries is good by luck."""
        return log(MOST_PAIRS)

    def generate(self, data: Data, kb: KnowledgeBase, covered: NDArray[np.bool_] | None = None, **most: int) -> list[tuple[float, Posed]]:
        """The poses that Γ suggests, matched, best first, with their evidence."""
        return generate(self, data, kb, covered, **most)

    def settle(
        self,
        pose: NDArray[np.float64],
        data: Data,
        kb: KnowledgeBase,
        free: NDArray[np.bool_] | None = None,
        hidden: NDArray[np.bool_] | None = None,
        rounds: int = 2,
    ) -> Posed:
        """The type at a pose: matched, refined, and matched again."""
        return settle(self, pose, self.allowed(data), data, kb, free, hidden, rounds)


def type_index(object_type: ObjectType, dv: Mapping[str, float]) -> TypeIndex:
    """Build the index of one type; dv 0 throughout (one feature type in all of Σo) counts every feature alike."""
    features = object_type.features
    weights = np.array([dv[feature.type] for feature in features])
    if not weights.any():
        weights = np.ones(len(features))
    points = np.array([feature.at for feature in features]).reshape(-1, 3)
    links = feature_links(points, [feature.arms for feature in features])
    moves = permutations(points, object_type.symmetries)
    triples = plane_triples(features)
    return TypeIndex(
        object_type,
        view_cells(object_type),
        points,
        weights,
        _anchors(weights),
        links[unique_sets(links, moves)],
        triples.take(unique_sets(triples.features, moves)),
    )


def _anchors(weights: NDArray[np.float64]) -> NDArray[np.intp]:
    """The features at least half as distinctive as the best, or the ``ANCHORS`` most distinctive where those are fewer than four."""
    order = np.argsort(-weights, kind="stable")[:ANCHORS]
    top = order[weights[order] >= 0.5 * weights.max()]
    return np.sort(top if len(top) >= 4 else order)


def generate(
    index: TypeIndex,
    data: Data,
    kb: KnowledgeBase,
    covered: NDArray[np.bool_] | None = None,
    *,
    refined: int = REFINED,
    verified: int = VERIFIED,
) -> list[tuple[float, Posed]]:
    """The best distinct poses of one type as (log-likelihood ratio against clutter, hypothesis), best first.

    ``covered`` (H, W): where accepted opaque objects stand in the ideal image. ``refined``, ``verified``: how many poses go that far.
    """
    allowed = index.allowed(data)
    if len(data.ids) < 4 or len(index.points) < 4 or not allowed.any():
        return []
    maps = distance_maps(allowed, data, covered)
    poses = np.concatenate([_from_pairs(index, allowed, maps, data), _from_triples(index, allowed, maps, data)])
    if not len(poses):
        return []
    worth = pose_votes(poses, index.cells, index.points, index.weights, maps, data)
    kept = poses[best_apart(worth, poses, index.cells, data, refined)]
    found = extend(kept, index.cells, index.points, index.weights, maps, data, kb.rates.match_tolerance)
    return _verified(found, index, allowed, maps, data, kb, verified)


def _from_pairs(
    index: TypeIndex, allowed: NDArray[np.bool_], maps: DistanceMaps, data: Data
) -> NDArray[np.float64]:
    """(N, 4, 4) the poses of those pairs that the anchors vote for most."""
    coarse = _pairs(index, allowed, data)
    worth = votes(coarse, index.cells, maps, index.weights, data, index.anchors)
    best = np.sort(np.argsort(-worth, kind="stable")[:VOTED])
    return coarse_poses(coarse.take(best), index.cells, data)


def _from_triples(
    index: TypeIndex, allowed: NDArray[np.bool_], maps: DistanceMaps, data: Data
) -> NDArray[np.float64]:
    """(N, 4, 4) the poses of those triples that the anchors and some of the other features vote for most."""
    members = np.flatnonzero(allowed[index.triples.features.ravel()].any(axis=0))
    if len(members) < 3:
        return np.zeros((0, 4, 4))
    poses = triple_poses(index.triples, image_triples(data, members), index.points, _scales(index, data), data.camera.f)
    others = np.setdiff1d(np.arange(len(index.points)), index.anchors)[::4]
    worth = pose_votes(poses, index.cells, index.points, index.weights, maps, data, np.concatenate([index.anchors, others]))
    return poses[np.sort(np.argsort(-worth, kind="stable")[:VOTED])]


def _pairs(index: TypeIndex, allowed: NDArray[np.bool_], data: Data) -> Pairs:
    """Pairs by the junctions' arms where the detector gave arms, by places alone where it gave none."""
    scales = _scales(index, data)
    anchored = np.asarray(allowed[index.anchors].any(axis=0))
    some, columns = data.only(anchored), np.flatnonzero(anchored)
    edged = index.cells.arms.shape[2] > 0 and bool(np.isfinite(some.arms).any())
    if edged and len(index.links):
        found = linked_pairs(index.cells, index.links, allowed[:, columns], some, scales)
    else:
        found = open_pairs(index.cells, index.anchors, allowed[:, columns], some, scales)
    return replace(found, datum=columns[found.datum], other_datum=columns[found.other_datum])


def _scales(index: TypeIndex, data: Data) -> tuple[float, float]:
    """Plausible pixels a metre: the object from 12 pixels to twice the image's height."""
    return 12.0 / index.cells.diameter, 2.0 * data.camera.height / index.cells.diameter


def _verified(
    found: Candidates, index: TypeIndex, allowed: NDArray[np.bool_], maps: DistanceMaps, data: Data, kb: KnowledgeBase, most: int
) -> list[tuple[float, Posed]]:
    """Cast rays for the best refined poses, match, polish once, and keep one of each heap of near-duplicates."""
    order = np.argsort(~np.isfinite(found.rms), kind="stable")  # they come best first
    poses: list[NDArray[np.float64]] = []
    for i in order:
        if len(poses) >= most or not np.isfinite(found.rms[i]):
            break
        pose = found.camera_from_object[i]
        if _plausible(pose, index) and not any(same_place(index.object_type, pose, old) for old in poses):
            poses.append(pose)
    first = [_matched_at(index, pose, allowed, maps, data, kb) for pose in poses]
    scored = [(evidence(p, data, kb, hidden).ratio, p) for p, hidden in _polished(index, first, allowed, maps, data, kb)]
    return distinct(sorted(scored, key=lambda pair: -pair[0]), index.object_type)


def _matched_at(
    index: TypeIndex, pose: NDArray[np.float64], allowed: NDArray[np.bool_], maps: DistanceMaps, data: Data, kb: KnowledgeBase
) -> tuple[Posed, NDArray[np.bool_]]:
    """The hypothesis at a pose, matched, and its features (F,) that accepted objects cover."""
    posed = pose_of(index.object_type, pose, data, kb)
    hidden = maps.is_covered(project_ideal(pose[None], index.points, data)[0])
    return matched(posed, data, allowed, kb.rates.match_tolerance, hidden=hidden), hidden


def _polished(
    index: TypeIndex,
    found: list[tuple[Posed, NDArray[np.bool_]]],
    allowed: NDArray[np.bool_],
    maps: DistanceMaps,
    data: Data,
    kb: KnowledgeBase,
) -> list[tuple[Posed, NDArray[np.bool_]]]:
    """All refined in one batch and matched again; those with fewer than four expected features detected are dropped."""
    used = np.array([p.candidate & p.detected & ~hidden for p, hidden in found]).reshape(len(found), len(index.points))
    some = np.flatnonzero(used.sum(axis=1) >= 4)
    if not len(some):
        return []
    poses = np.array([found[i][0].camera_from_object for i in some])
    uv = np.array([data.uv[np.maximum(found[i][0].matches, 0)] for i in some])
    points = np.broadcast_to(index.points, (len(some), *index.points.shape))
    weights = used[some] * _precision(index, kb)
    better = refine_poses(poses, points, uv, weights, data.camera, huber=ROBUST)[0]
    return [_matched_at(index, pose, allowed, maps, data, kb) for pose in better]


def _plausible(pose: NDArray[np.float64], index: TypeIndex) -> bool:
    """Finite and wholly in front of the camera."""
    centre = pose[:3, :3] @ index.cells.centre + pose[:3, 3]
    return bool(np.isfinite(pose).all() and centre[2] > 0.5 * index.cells.diameter)


def settle(
    index: TypeIndex,
    pose: NDArray[np.float64],
    allowed: NDArray[np.bool_],
    data: Data,
    kb: KnowledgeBase,
    free: NDArray[np.bool_] | None = None,
    hidden: NDArray[np.bool_] | None = None,
    rounds: int = 2,
) -> Posed:
    """Match exactly (D7, D8), refine on the expected features that were detected, and match again, until nothing changes or ``rounds``."""
    tolerance = kb.rates.match_tolerance
    posed = matched(pose_of(index.object_type, pose, data, kb), data, allowed, tolerance, free, hidden)
    for _ in range(rounds):
        better = polish(index, posed, data, kb, hidden)
        if better is None:
            break
        new = matched(pose_of(index.object_type, better, data, kb), data, allowed, tolerance, free, hidden)
        stable = np.array_equal(new.matches, posed.matches)
        posed = new
        if stable:
            break
    return posed


def polish(
    index: TypeIndex, posed: Posed, data: Data, kb: KnowledgeBase, hidden: NDArray[np.bool_] | None = None
) -> NDArray[np.float64] | None:
    """Least squares (4, 4) on the expected features that were detected, or None where they are fewer than four."""
    used = posed.candidate & posed.detected
    used = used if hidden is None else used & ~hidden
    if used.sum() < 4:
        return None
    uv = data.uv[np.maximum(posed.matches, 0)][None]
    result = refine_poses(posed.camera_from_object[None], index.points[None], uv, used[None] * _precision(index, kb), data.camera, huber=ROBUST)
    return np.asarray(result[0][0])


def _precision(index: TypeIndex, kb: KnowledgeBase) -> NDArray[np.float64]:
    """(F,) weights of the features in least squares: 1/σ², the KB's own σ being 1."""
    noise = np.array([kb.rates.sigma_of(feature.type) for feature in index.object_type.features])
    return np.asarray((kb.rates.sigma / noise) ** 2)


def same_place(object_type: ObjectType, one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two poses of a type are within tolerance of each other, up to its symmetries (§8, near-duplicates)."""
    distance = float(np.linalg.norm(one[:3, 3]))
    middle = np.append(object_type.surface.centre if object_type.surface is not None else np.zeros(3), 1.0)
    if object_type.surface is not None and np.linalg.norm((one - other) @ middle) > 2.0 * SAME_PLACE * distance:
        return False  # symmetries keep the middle where it is
    rotation, translation = pose_error(one, other, object_type.symmetries)
    return bool(rotation < SAME_ROTATION and translation < SAME_PLACE * distance)


def distinct(scored: list[tuple[float, Posed]], object_type: ObjectType) -> list[tuple[float, Posed]]:
    """The first of each heap of near-duplicates (§8)."""
    kept: list[tuple[float, Posed]] = []
    for worth, posed in scored:
        if not any(same_place(object_type, posed.camera_from_object, old.camera_from_object) for _, old in kept):
            kept.append((worth, posed))
    return kept


__all__ = ["TypeIndex", "distinct", "generate", "same_place", "settle", "type_index"]
