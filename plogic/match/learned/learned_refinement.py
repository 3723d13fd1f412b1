"""Coarse poses of a learned type, refined many at once on the pairs and the sides of edges that agree with them.

* ``Round``: how near what agrees must be, and how many go on, in one round: ``Round(0.05, 3.0, 7.0, 30, 12)``
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.poses.refine import Steps, refined_poses
from plogic.match.judged.settling import FEWEST
from plogic.match.learned.agreement import agreement, held_by
from plogic.match.learned.side_fit import side_fit
from plogic.match.learned.single_poses import plausible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.learned.agreement import Held
    from plogic.match.learned.keypoint_pairs import Pairs
    from plogic.match.learned.learned_index import LearnedIndex
    from plogic.match.learned.side_fit import SideFit

    Floats = NDArray[np.float64]


class Round(NamedTuple):
    """One round: what agrees is within ``share`` of the diameter and ``pixels``, and sides within ``reach`` pixels across their edge.

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
    """Refined on the pairs and the sides of edges that agree, ever more tightly, best first, with their worth; those with too few are dropped.

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
