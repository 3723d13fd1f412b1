"""Hypotheses of all types from Γ (§6.3, §7): triples, votes, refinement, and only then rays."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.refine import refined_poses
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Data, project_ideal
from plogic.match.hand.distance_maps import DistanceMaps, Drawn
from plogic.match.hand.extend import Candidates, extend, firsts
from plogic.match.hand.links import linked_poses
from plogic.match.hand.place_votes import Coarse, coarse_poses, pose_votes
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import FEWEST, matched, pose_of
from plogic.match.judged.rivals import Places, apart, distinct

if TYPE_CHECKING:
    from collections.abc import Callable

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.hand.hand_models import TypeIndex
    from plogic.match.hand.place_index import PlaceIndex
    from plogic.match.judged.type_models import Found

LINKED = 2000
"""Coarse poses of links of a type that all features vote on: the best by the votes of its anchors."""


class Width(NamedTuple):
    """How many poses go on: of triples, those of most ``votes`` of some features; of these, no two alike, ``refined``.

    Of these, with rays cast, ``verified``.
    """

    votes: int
    refined: int
    verified: int


def usual(types: int) -> Width:
    """Of so many types."""
    return Width(3500 + 90 * types, 150 + 6 * types, 22 + types)


ALIKE = float(np.radians(12.0)), 0.08
"""Two coarse poses of a type are alike that differ by less, radians, and share of the distance."""
ROBUST = 0.25
"""Pixels beyond which a match weighs less in the last refinement: a wrong match within the tolerance must not pull the
pose."""


def generate(
    index: PlaceIndex,
    data: Data,
    kb: KnowledgeBase,
    covered: Mask | None = None,
    *,
    coarse: Coarse | None = None,
    width: Width | None = None,
    drawn: Drawn | None = None,
    check: Callable[[], None] = unhurried,
) -> dict[str, Found]:
    """The best distinct poses of all types, by type, as (log-likelihood ratio against clutter, hypothesis), best first.

    ``covered`` (H, W): where accepted opaque objects stand in the ideal image. ``coarse``: poses of triples of more
    data, these among them. ``width``: how many poses go on, by default as is usual. ``drawn``: maps of the same Γ.
    ``check`` is called between stages, and between blocks of what grows with Γ, and may raise to end the search.
    """
    check()
    result: dict[str, Found] = {each.object_type.name: [] for each in index.indices}
    allowed = index.allowed(data)
    if len(data.ids) < FEWEST or not allowed.any():
        return result
    maps = (drawn or Drawn(data.whole)).maps(allowed, data, covered, check)
    width = width or usual(len(index.indices))
    start = _apart(
        index, data, maps, coarse or coarse_poses(index, data, maps, width.votes, check), width.refined, check
    )
    check()
    found = extend(index, start, maps, data, kb.rates.match_tolerance)
    check()
    scored: dict[str, Found] = {name: [] for name in result}
    for posed, hidden in _verified(found, index, maps, data, kb, width.verified, check):
        check()
        scored[posed.type].append((evidence(posed, data, kb, hidden).ratio, posed))
    return result | {kind: distinct(some, some[0][1].object_type) for kind, some in scored.items() if some}


def of_triples(index: PlaceIndex, data: Data, drawn: Drawn, check: Callable[[], None] = unhurried) -> Coarse:
    """The coarse poses of all types that triples of the data vote for; ``drawn``: maps of the same Γ."""
    maps = drawn.maps(index.allowed(data), data, None, check)
    return coarse_poses(index, data, maps, usual(len(index.indices)).votes, check)


def best_votes(
    index: PlaceIndex,
    data: Data,
    coarse: Coarse,
    covered: Mask | None,
    drawn: Drawn,
    check: Callable[[], None] = unhurried,
) -> Floats:
    """(T,) the most votes of a coarse pose of each type in some data; −∞ of none."""
    best = np.full(len(index.indices), -np.inf)
    if len(data.ids):
        maps = drawn.maps(index.allowed(data), data, covered, check)
        kind, poses = _coarse(index, data, maps, coarse, check)
        np.maximum.at(best, kind, pose_votes(index, data, maps, kind, poses))
    return best


def _coarse(
    index: PlaceIndex, data: Data, maps: DistanceMaps, triples: Coarse, check: Callable[[], None]
) -> tuple[Indices, Floats]:
    """Types (N,) and coarse poses (N, 4, 4): of triples, and of links where junctions have arms."""
    kinds, linked = linked_poses(index, data, maps, LINKED, check)
    check()
    return np.concatenate([triples.kind, kinds]), np.concatenate([triples.poses.astype(float), linked])


def _apart(
    index: PlaceIndex, data: Data, maps: DistanceMaps, triples: Coarse, most: int, check: Callable[[], None]
) -> Candidates:
    """The best coarse poses of all types, no two alike."""
    kind, poses = _coarse(index, data, maps, triples, check)
    worth = pose_votes(index, data, maps, kind, poses).astype(float)
    middles = np.einsum("nij,nj->ni", poses[:, :3, :3], index.centres[kind]) + poses[:, :3, 3]
    some = apart(poses, middles, worth, most, ALIKE, kind)
    return Candidates(kind[some], poses[some], np.zeros((len(some), 0), np.intp), worth[some])


def _verified(
    found: Candidates,
    index: PlaceIndex,
    maps: DistanceMaps,
    data: Data,
    kb: KnowledgeBase,
    most: int,
    check: Callable[[], None],
) -> list[tuple[Hypothesis, Mask]]:
    """Cast rays for the best refined poses, match, and polish them in one batch; each with its covered features (F,).

    Those with fewer than four expected features detected are dropped.
    """
    allowed = [each.allowed(data) for each in index.indices]

    def at(kind: int, pose: Floats) -> tuple[Hypothesis, Mask]:
        check()
        each = index.indices[kind]
        posed = pose_of(each.object_type, pose, data, kb)
        hidden = maps.is_covered(project_ideal(pose[None], each.points, data)[0])
        return matched(posed, data, allowed[kind], kb.rates.match_tolerance, hidden=hidden), hidden

    best = _distinct(found, index, most)
    kinds = found.kind[best].tolist()
    first = [at(kind, pose) for kind, pose in zip(kinds, found.poses[best], strict=True)]
    used, matches = (
        np.zeros((len(first), index.own.shape[1]), bool),
        np.zeros((len(first), index.own.shape[1]), np.intp),
    )
    precision = np.zeros(used.shape)
    for row, (kind, (posed, hidden)) in enumerate(zip(kinds, first, strict=True)):
        count = len(posed.matches)
        used[row, :count], matches[row, :count] = posed.expected(hidden) & posed.detected, np.maximum(posed.matches, 0)
        precision[row, :count] = index.indices[kind].precision(kb.rates)
    some = np.flatnonzero(used.sum(axis=1) >= FEWEST)
    if not len(some):
        return []
    kind, column = np.array(kinds)[some], firsts(used[some])
    weights = np.take_along_axis(used[some] * precision[some], column, axis=1)
    uv = data.uv[np.take_along_axis(matches[some], column, axis=1)]
    poses = np.array([first[i][0].camera_from_object for i in some])
    better = refined_poses(poses, index.points[kind[:, None], column], uv, weights, data.camera, huber=ROBUST)
    return [at(k, pose) for k, pose in zip(kind.tolist(), better, strict=True)]


def _distinct(found: Candidates, index: PlaceIndex, most: int) -> list[int]:
    """The first candidates that are plausible and not at one place, up to symmetry."""
    places = [Places(each.object_type) for each in index.indices]
    some = np.flatnonzero(np.isfinite(found.worth)).tolist()
    new = (
        i
        for i, kind in zip(some, found.kind[some].tolist(), strict=True)
        if _plausible(found.poses[i], index.indices[kind]) and places[kind].add(found.poses[i])
    )
    return list(islice(new, most))


def _plausible(pose: Floats, index: TypeIndex) -> bool:
    """Finite and wholly in front of the camera."""
    centre = pose[:3, :3] @ index.centre + pose[:3, 3]
    return bool(np.isfinite(pose).all() and centre[2] > 0.5 * index.cells.diameter)
