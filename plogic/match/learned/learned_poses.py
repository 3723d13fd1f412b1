"""Δh of a learned type: every pair is a pose, poses vote, and the best that are apart are refined and settled.

On a known plane what rests has three ways to move, not six. So a pose that one pair fixes coarsely is set down: turned
the least way that puts one of the body's resting faces on the plane, and moved along the line of sight until the face
touches it. What is left is its place and its turn on the plane, which few data refine.

* ``generate``: the hypotheses of a type anywhere; ``resting``: those on a plane
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.bodies.standing import Contact
from geometry.frames import least_turns
from plogic.match.judged.evidence import evidence
from plogic.match.judged.expectation import FEWEST
from plogic.match.judged.rivals import apart, distinct, distinct_poses
from plogic.match.learned.agreement import agreement, votes
from plogic.match.learned.keypoints import SEEDS, Pairs, depths, pairs_of, plausible, sights, single_poses, turns
from plogic.match.learned.learned_pixels import NO_POSES, NOT_SEEN, Before, Seen, by_pixels
from plogic.match.learned.learned_refinement import ROUNDS, Round, held_at, refined

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats, Mask
    from geometry.bodies.resting import Plane
    from geometry.bodies.standing import Known
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex


VOTE = (0.12, 3.0)
"""Share of the diameter, and pixels, within which places agree in the vote: a single pair's pose is coarse."""
REFINED, VERIFIED = 80, 4
"""Poses whose sides are looked at, the best by votes and no two alike; and those that are settled, the best that
refinement comes to."""
APART, TURNED = 0.12, 0.35
"""Two poses are alike whose middles are nearer than this share of the distance and whose rotations differ by less,
radians."""
HOPELESS = -20.0
"""Poses that explain less than this beyond chance as they are, before they are settled, are given up, to save time."""
TILTED = 4.0
"""Poses of less worth are not tried with their other tilt."""
NOBODY = np.zeros((0, 4))
WORTHLESS = 12.0
"""Poses of less worth are given up before they are settled: few right ones, and most of the wrong ones
(``benchmarks/learned_spreads.py``)."""


class Voted(NamedTuple):
    """Poses (N, 4, 4), one for each of the surest of ``pairs``, with the votes (N,) of all pairs."""

    pairs: Pairs
    poses: Floats
    votes: Floats


def voted(index: LearnedIndex, data: Data) -> Voted:
    """What the pairs of a type in some data vote for."""
    pairs = pairs_of(index, data)
    poses = single_poses(index, pairs.take(slice(SEEDS)), data) if len(pairs) >= FEWEST else np.zeros((0, 4, 4))
    return Voted(pairs, poses, _votes(index, poses, pairs, data, VOTE) if len(poses) else np.zeros(0))


def generate(
    index: LearnedIndex,
    data: Data,
    kb: KnowledgeBase,
    taken: Floats = NOBODY,
    *,
    before: Sequence[Before] = (),
    width: tuple[int, int] = (REFINED, VERIFIED),
    of: Voted | None = None,
    seen: Seen = NOT_SEEN,
) -> list[tuple[float, Hypothesis]]:
    """The settled poses with their log-likelihood ratios, best first.

    ``width``: how many poses are refined and settled; ``of``: what the data vote for, where that is known;
    ``before``: what hides pixels, where it is nearer; ``seen``: poses that the photo suggests otherwise.

    ``taken`` (N, 4): middles, camera frame, and inner radii of bodies that are there already, m: poses that overlap
    them (A4) are not looked at.
    """
    thin = width[1] <= VERIFIED
    poses, worth = proposed(index, data, kb, *width, taken, thin=thin, of=of)
    if data.photo is not None and len(poses) + len(seen.poses) and index.paint is not None:
        clear = clear_of(taken, index, poses)
        seen = seen.some(clear_of(taken, index, seen.poses))
        return by_pixels(index, poses[clear], worth[clear], data, kb, before=before, seen=seen)
    poses = poses[worth >= WORTHLESS] if thin else poses
    return settled_best(index, poses[clear_of(taken, index, poses)], data, kb, width[1])


def clear_of(taken: Floats, index: LearnedIndex, poses: Floats) -> Mask:
    """(H,) which poses (H, 4, 4) may keep out of bodies already there (N, 4), as far as inner radii tell (A4)."""
    apart = np.linalg.norm((poses[:, :3, :3] @ index.centre + poses[:, :3, 3])[:, None] - taken[:, :3], axis=2)
    return np.asarray((apart > taken[:, 3] + index.inner_radius).all(axis=1))


def settled_best(
    index: LearnedIndex, best: Floats, data: Data, kb: KnowledgeBase, verified: int
) -> list[tuple[float, Hypothesis]]:
    """Of refined poses (N, 4, 4), best first, the first ``verified`` apart, settled, with log-likelihood ratios."""
    seen = [index.settle(pose, data, kb, rounds=0) for pose in distinct_poses(index.object_type, best, verified)]
    hopeful = [posed for posed in seen if _enough(posed) and evidence(posed, data, kb).surplus > HOPELESS]
    settled = [index.settle(posed, data, kb, rounds=2) for posed in hopeful]
    scored = [(evidence(posed, data, kb).ratio, posed) for posed in settled if _enough(posed)]
    return distinct(scored, index.object_type)


def proposed(
    index: LearnedIndex,
    data: Data,
    kb: KnowledgeBase,
    most: int = REFINED,
    tried: int = VERIFIED,
    taken: Floats = NOBODY,
    *,
    thin: bool = True,
    of: Voted | None = None,
) -> tuple[Floats, Floats]:
    """Poses (N, 4, 4), refined but not settled, with their worth (N,), best first; ``most``: so many are.

    ``tried``: so many are tried with their other tilt; ``thin``: only the hopeful ones are, and ever fewer poses are
    refined.
    """
    nothing = np.zeros((0, 4, 4)), np.zeros(0)
    pairs, poses, worth = of or voted(index, data)
    clear = clear_of(taken, index, poses)
    if not clear.any():
        return nothing
    granularity, some = data.camera.f / kb.f_ref, _best(index, poses[clear], worth[clear], most)
    best, worth = refined(index, some, pairs, data, granularity, thin=thin)
    if not len(best):
        return nothing
    some = best[:tried][worth[:tried] >= TILTED] if thin else best
    other, its = refined(index, tilted(index, some, pairs, data), pairs, data, granularity, thin=thin)
    best, worth = np.concatenate([best, other]), np.concatenate([worth, its])
    order = np.argsort(-worth, kind="stable")
    return best[order], worth[order]


def _enough(posed: Hypothesis) -> bool:
    return int((posed.candidate & posed.detected).sum()) >= FEWEST


def _votes(index: LearnedIndex, poses: Floats, pairs: Pairs, data: Data, within: tuple[float, float]) -> Floats:
    """(N,) of poses (N, 4, 4); ``within``: a share of the diameter, and pixels."""
    return votes(agreement(index, poses, pairs, data, *within), pairs)


def _best(index: LearnedIndex, poses: Floats, worth: Floats, most: int) -> Floats:
    """The best of poses (N, 4, 4) by their votes, no two alike."""
    return poses[apart(poses, poses[:, :3, :3] @ index.centre + poses[:, :3, 3], worth, most, (TURNED, APART))]


def tilted(index: LearnedIndex, poses: Floats, pairs: Pairs, data: Data) -> Floats:
    """(H, 4, 4) the other pose of each that shows a flat side nearly alike.

    The side, mirrored in depth, and turned proper by its normal.

    From afar a plane's tilt is known up to this (two branches of planar POSIT, §6.1); which of them holds, perspective
    and lobes decide.
    """
    held, places = held_at(index, poses, pairs, data, ROUNDS[-2]), index.places[pairs.lobe]
    normals = index.cloud.normal[index.cloud.feature[pairs.lobe]]
    little = 1e-9  # a pose that nothing holds is turned about the middle of all
    total = held.sums(len(poses))[:, None] + little
    normal, own = ((held.sums(len(poses), rows) + little * rows.mean(axis=0)) / total for rows in (normals, places))
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    middle = np.einsum("hij,hj->hi", poses[:, :3, :3], own) + poses[:, :3, 3]
    sight = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    still = np.eye(3)
    other = poses.copy()
    other[:, :3, :3] = (
        (still - 2.0 * sight[:, :, None] * sight[:, None])
        @ poses[:, :3, :3]
        @ (still - 2.0 * normal[:, :, None] * normal[:, None])
    )
    other[:, :3, 3] = middle - np.einsum("hij,hj->hi", other[:, :3, :3], own)
    return other


TIPPED, FARTHER = 0.7, 0.5
"""Greatest angle (radians) by which a coarse pose is turned to rest, and greatest logarithm of the ratio by which its
pair is moved in depth."""
GRAZING = 0.01
"""Cosine of the angle to the plane's normal of a line of sight that runs along the plane: where it meets it is not
known."""
VOTE_RESTING = (0.06, 3.0)
"""Share of the diameter, and pixels, within which places agree in the vote: half of what a pose in the air is given."""
MOST_RESTING, VERIFIED_RESTING = 24, 3
"""Poses whose sides are looked at; and those that are settled."""
ROUNDS_RESTING = (
    Round(0.06, 3.0, 12.0, 20, 16),
    Round(0.04, 3.0, 7.0, 30, 8),
    Round(0.015, 2.5, 4.0, 40, 5),
    Round(0.0, 3.0, 3.0, 60, 4),
)
"""As those of poses in the air, from nearer by, and of fewer."""


def resting(
    index: LearnedIndex,
    known: Known,
    data: Data,
    kb: KnowledgeBase,
    taken: Floats,
    *,
    before: Sequence[Before] = (),
    seen: Seen = NOT_SEEN,
    anew: bool = True,
) -> list[tuple[float, Hypothesis]]:
    """Γ's poses on the plane, settled and then free to leave it, with log-likelihood ratios, best first.

    ``taken`` (N, 4): middles, camera frame, and inner radii of bodies that stand there already, m; ``seen``:
    poses on the plane that the photo suggests otherwise; not ``anew``: these alone. By pixels they leave it as far as
    it is not known.
    """
    best, worth = _rested(index, known, data, kb, taken) if anew else (NO_POSES, np.zeros(0))
    if data.photo is not None and index.paint is not None:
        seen = seen.some(clear_of(taken, index, seen.poses))
        contact = Contact(known, index.resting)
        return by_pixels(index, best, worth, data, kb, before=before, seen=seen, contact=contact)
    some = settled_best(index, best[worth >= WORTHLESS], data, kb, VERIFIED_RESTING)
    return [(ratio, posed.told(released=posed.camera_from_object)) for ratio, posed in some]


def _rested(index: LearnedIndex, known: Known, data: Data, kb: KnowledgeBase, taken: Floats) -> tuple[Floats, Floats]:
    """Poses (N, 4, 4) on the plane, refined on it, with their worth (N,), best first."""
    pairs, plane = pairs_of(index, data), known.plane
    poses = set_down(index, pairs, plane, data)
    poses = poses[known.over(poses[:, :3, :3] @ index.centre + poses[:, :3, 3])]
    poses = poses[clear_of(taken, index, poses)]
    if not len(poses):
        return NO_POSES, np.zeros(0)
    some = _best(index, poses, _votes(index, poses, pairs, data, VOTE_RESTING), MOST_RESTING)
    granularity = data.camera.f / kb.f_ref
    return refined(index, some, pairs, data, granularity, rounds=ROUNDS_RESTING, moves=plane.moves)


def set_down(index: LearnedIndex, pairs: Pairs, plane: Plane, data: Data) -> Floats:
    """(N, 4, 4) the poses on the plane that are near to those that the pairs fix in the air.

    Each stands on one of its resting faces.
    """
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
        poses[:, :3, :3] = least_turns(is_down[near], -plane.up) @ turned[near]
        poses[:, :3, 3] = rays[near] * depth[near, None] - np.einsum("nij,nj->ni", poses[:, :3, :3], places[near])
        found.append(poses)
    poses = np.concatenate(found)
    return poses[plausible(index, poses)]
