"""Δh of a learned type on a known plane: a pair is a pose already (``single``), and what rests on the plane has three ways to move, not six.

So a pose that one pair fixes coarsely is set down: turned the least way that puts one of the body's resting faces on
the plane, and moved along the line of sight until the face touches it. What is left is its place and its turn on the
plane, which few data refine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.judged.alike import apart
from plogic.match.learned.agreement import agreement, votes
from plogic.match.learned.keypoint_pairs import pairs_of
from plogic.match.learned.learned_poses import APART, TURNED, WORTHLESS, clear_of, settled_best
from plogic.match.learned.learned_refinement import Round, refined
from plogic.match.learned.single_poses import depths, plausible, sights, turns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.bodies.resting import Plane
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.learned.keypoint_pairs import Pairs
    from plogic.match.learned.learned_index import LearnedIndex

    Floats = NDArray[np.float64]

TIPPED, FARTHER = 0.7, 0.5
"""Greatest angle (radians) by which a coarse pose is turned to rest, and greatest logarithm of the ratio by which its
pair is moved in depth."""
GRAZING = 0.01
"""Cosine of the angle to the plane's normal of a line of sight that runs along the plane: where it meets it is not
known."""
VOTE = (0.06, 3.0)
"""Share of the diameter, and pixels, within which places agree in the vote: half of what a pose in the air is given."""
MOST, VERIFIED = 24, 3
"""Poses whose sides are looked at; and those that are settled."""
ROUNDS = (
    Round(0.06, 3.0, 12.0, 20, 16),
    Round(0.04, 3.0, 7.0, 30, 8),
    Round(0.015, 2.5, 4.0, 40, 5),
    Round(0.0, 3.0, 3.0, 60, 4),
)
"""As those of poses in the air, from nearer by, and of fewer."""


def resting(
    index: LearnedIndex, plane: Plane, data: Data, kb: KnowledgeBase, taken: Floats
) -> list[tuple[float, Hypothesis]]:
    """The poses that Γ suggests on the plane, settled, which are free to leave it then, with their log-likelihood ratios, best first.

    ``taken`` (N, 4): middles, camera frame, and inner radii of bodies that stand there already, m.
    """
    pairs = pairs_of(index, data)
    poses = set_down(index, pairs, plane, data)
    poses = poses[clear_of(taken, index, poses)]
    middles = poses[:, :3, :3] @ index.centre + poses[:, :3, 3]
    if not len(poses):
        return []
    worth = votes(agreement(index, poses, pairs, data, *VOTE), pairs)
    some = poses[apart(poses, middles, worth, MOST, (TURNED, APART))]
    best, worth = refined(index, some, pairs, data, data.camera.f / kb.f_ref, rounds=ROUNDS, moves=plane.moves)
    return settled_best(index, best[worth >= WORTHLESS], data, kb, VERIFIED)


def set_down(index: LearnedIndex, pairs: Pairs, plane: Plane, data: Data) -> Floats:
    """(N, 4, 4) the poses on the plane that are near to those that the pairs fix in the air; each stands on one of its resting faces."""
    rays, places = sights(pairs, data), index.places[pairs.lobe]
    turned, told, falling = turns(index, pairs, data), depths(index, pairs, data), rays @ plane.up
    found = [np.zeros((0, 4, 4))]
    for down, reach in zip(index.resting.down, index.resting.reach, strict=True):
        is_down = turned @ down
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (reach - places @ down - plane.offset) / falling
            farther = np.abs(np.log(np.maximum(depth, 0.0) / told))
        near = (np.abs(falling) > GRAZING) & (farther < FARTHER) & (is_down @ plane.up < -np.cos(TIPPED))
        poses = np.tile(np.eye(4), (int(near.sum()), 1, 1))
        poses[:, :3, :3] = _least_turns(is_down[near], -plane.up) @ turned[near]
        poses[:, :3, 3] = rays[near] * depth[near, None] - np.einsum("nij,nj->ni", poses[:, :3, :3], places[near])
        found.append(poses)
    poses = np.concatenate(found)
    return poses[plausible(index, poses)]


def _least_turns(start: Floats, end: Floats) -> Floats:
    """(N, 3, 3) the least rotations of unit vectors (N, 3) to another (3,), which is opposite to none."""
    axis = np.cross(start, end)
    across = np.cross(np.eye(3), axis[:, None, :])
    return np.asarray(np.eye(3) + across + across @ across / (1.0 + start @ end)[:, None, None])
