"""Coarse poses of a learned type, refined many at once on the pairs and the sides of edges that agree with them.

* ``Round``: how near what agrees must be, and how many go on, in one round: ``Round(0.05, 3.0, 7.0, 30, 12)``
* ``SideFit``: of H poses, at most Q appearances each, the sides that are theirs, and how well they fit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.refine import Steps, refined_poses
from plogic.match.gamma.data import Data, viewpoints_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.gamma.side_looks import looks_fit
from plogic.match.judged.evidence import MOST_HIT
from plogic.match.judged.expectation import FEWEST
from plogic.match.learned.agreement import Held, agreement, first_held, held_by
from plogic.match.learned.keypoints import Pairs, plausible
from plogic.match.learned.sides import ALONG, side_pairs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats, Indices
    from plogic.match.learned.learned_models import LearnedIndex


LOOSE = 0.25
"""Standard deviation, radians, by which a side faces another way where the pose is coarse."""


@dataclass(frozen=True)
class SideFit:
    """``points`` (H, Q, 3) m, object frame; ``uv`` (H, Q, 2) pixels; ``across`` (H, Q, 2).

    ``weight`` (H, Q), 0 where there is none.

    ``worth`` (H,): about the logarithm of how much likelier the sides are of these poses than of clutter.
    """

    points: Floats
    uv: Floats
    across: Floats
    weight: Floats
    worth: Floats


def side_fit(index: LearnedIndex, poses: Floats, data: Data, granularity: float, reach: float, most: int) -> SideFit:
    """Of poses (H, 4, 4), the ``most`` surest sides, each with the best within ``reach`` px across its line.

    And a little more along it.
    """
    pose, lobe = _expected(index, poses, data, granularity, most)
    at = np.einsum("nij,nj->ni", poses[pose, :3, :3], index.places[lobe]) + poses[pose, :3, 3]
    uv = data.camera.project(at)
    angle = screen_angle(np.einsum("nij,nj->ni", poses[pose, :3, :3], index.cloud.up[lobe]), at)
    inside = data.camera.contains(uv)
    pose, lobe, uv, angle = pose[inside], lobe[inside], uv[inside], angle[inside]
    pairs, further = side_pairs(index, data, lobe, uv, angle), ALONG + reach / 3.0
    near = pairs.take((np.abs(pairs.off) <= reach) & (np.abs(pairs.along) <= further))
    sigma = max(reach / 2.5, 1.0)
    fit = np.exp(-0.5 * (near.off / sigma) ** 2 - 0.5 * (near.turned / LOOSE) ** 2) / (
        np.sqrt(2.0 * np.pi) * sigma * 2.0 * further
    )
    fit *= (
        looks_fit(index.looks[lobe[near.place]], data.looks[near.datum], near.colours, data.contrasts)
        / pairs.usual(reach, len(lobe))[near.place]
    )
    best = np.lexsort((near.datum, -fit, near.place))
    best = best[np.unique(near.place[best], return_index=True)[1]]  # of each place the pair that fits best
    place, datum, fit = near.place[best], near.datum[best], fit[best]
    hit = np.minimum(index.cloud.hit[lobe], MOST_HIT)
    gain = np.log1p(-hit)
    gain[place] = np.log1p(hit[place] * (fit - 1.0))
    slot = np.arange(len(pose)) - np.searchsorted(pose, pose)
    table = len(poses), int(slot.max(initial=-1)) + 1
    worth = np.asarray(np.bincount(pose, gain, minlength=len(poses)), float)
    result = SideFit(np.zeros((*table, 3)), np.zeros((*table, 2)), np.zeros((*table, 2)), np.zeros(table), worth)
    result.points[pose, slot] = index.places[lobe]
    result.across[pose, slot] = np.column_stack([np.cos(angle), np.sin(angle)])
    result.uv[pose[place], slot[place]], result.weight[pose[place], slot[place]] = (
        data.uv[datum],
        hit[place] * fit / (fit + 1.0),
    )
    return result


def _expected(index: LearnedIndex, poses: Floats, data: Data, granularity: float, most: int) -> tuple[Indices, Indices]:
    """Poses and the appearances of sides that each expects, the ``most`` of the greatest hit rates."""
    lobes = index.lobes_of_sides
    if not len(lobes.which) or not data.sided.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    pose, place = first_held(lobes, viewpoints_of(poses), granularity, most)
    return pose, lobes.which[place]


class Round(NamedTuple):
    """One round: agreement is within ``share`` of the diameter and ``pixels``; of sides, ``reach`` px across the edge.

    ``sides`` of each pose are looked for, the surest; ``kept`` poses go on, the best by what agrees.
    """

    share: float
    pixels: float
    reach: float
    sides: int
    kept: int


ROUNDS = (
    Round(0.12, 3.0, 12.0, 20, 40),
    Round(0.05, 3.0, 7.0, 30, 12),
    Round(0.015, 2.5, 4.0, 40, 6),
    Round(0.0, 3.0, 3.0, 60, 5),
)
"""Of poses that one pair fixed."""
SIDES_A_PAIR, SIDE_WEIGHT = 4.0, 0.3
"""Sides that are as good as one pair to hold a pose, and how much each counts against a pair in its refinement."""
PAIR_WORTH, SIDE_WORTH = 4.0, 0.35
"""About how much a pair, and a unit of the worth of sides, says of a pose (logarithm of a likelihood ratio), where
poses are put in order."""
FEW = 4
"""Steps of least squares in a round: what agrees is asked again after them."""
ROBUST = 2.0
"""Pixels beyond which a pair weighs less."""


def refined(
    index: LearnedIndex,
    poses: Floats,
    pairs: Pairs,
    data: Data,
    granularity: float,
    *,
    rounds: Sequence[Round] = ROUNDS,
    thin: bool = True,
    moves: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Refined on the pairs and the sides of edges that agree, ever more tightly, best first, with their worth.

    Those with too few are dropped.

    ``granularity``: f / f_ref. ``thin``: ever fewer go on, the best. ``moves`` (6, M): the steps that poses may take,
    as in ``Steps``.
    """
    for now in rounds:
        held = held_at(index, poses, pairs, data, now)
        sides = side_fit(index, poses, data, granularity, now.reach, now.sides)
        count = np.bincount(held.pose, minlength=len(poses))
        enough = (count > 0) & (count + (sides.weight > 0.0).sum(axis=1) / SIDES_A_PAIR >= FEWEST)
        some = np.flatnonzero(enough)
        some = some[np.argsort(-_worth(held, sides)[some], kind="stable")[: now.kept if thin else None]]
        if not len(some):
            return poses[some], np.zeros(0)
        slot = np.arange(len(held.pose)) - np.searchsorted(held.pose, held.pose)
        which, used = np.zeros((len(poses), count.max()), np.intp), np.zeros((len(poses), count.max()))
        which[held.pose, slot], used[held.pose, slot] = held.pair, held.weight
        which = which[some]
        both = (
            np.concatenate([index.places[pairs.lobe[which]], sides.points[some]], axis=1),
            np.concatenate([data.uv[pairs.datum[which]], sides.uv[some]], axis=1),
            np.concatenate([used[some], sides.weight[some] * SIDE_WEIGHT], axis=1),
        )
        across = np.concatenate([np.full((*which.shape, 2), np.nan), sides.across[some]], axis=1)
        poses = refined_poses(poses[some], *both, data.camera, Steps(FEW, moves), huber=ROBUST, across=across)
        poses = poses[plausible(index, poses)]
    last = rounds[-1]
    worth = _worth(
        held_at(index, poses, pairs, data, last), side_fit(index, poses, data, granularity, last.reach, last.sides)
    )
    order = np.argsort(-worth, kind="stable")
    return poses[order], worth[order]


def _worth(held: Held, sides: SideFit) -> Floats:
    """(H,) what pairs and sides say of poses."""
    return np.asarray(PAIR_WORTH * held.sums(len(sides.worth)) + SIDE_WORTH * sides.worth)


def held_at(index: LearnedIndex, poses: Floats, pairs: Pairs, data: Data, now: Round) -> Held:
    """What poses (H, 4, 4) are held by, of pairs as near as a round asks."""
    return held_by(agreement(index, poses, pairs, data, now.share, now.pixels), pairs, index.cloud.feature[pairs.lobe])
