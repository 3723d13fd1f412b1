"""A4 to a millimetre: objects that reach into each other by no more than poses are wrong are moved apart, all together.

Of all poses that keep them apart those are taken that Γ says the most for: each pose's information, from its matches,
tells what a move costs.

* ``moved_apart(posed, information)``: the poses, and which pairs still reach into each other
* ``reaches_into(one, other)``: whether two do, by more than a millimetre
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from geometry.bodies.overlap import Reach, reaches
from geometry.poses.reprojection import information
from plogic.match.judged.pose_information import LOOSE, sigmas
from plogic.match.judged.rivals import solid_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from geometry.arrays import Floats
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis


DEEP = 0.001
"""Metres by which two accepted objects may reach into each other."""
SPARE = 0.1
"""Share of that which is left when they are moved."""
ROUNDS = 12
"""Times that all are moved: the way out is known for flat contacts, and found again for others."""
FAR = 10.0
"""Standard deviations of its pose by which an object may be moved: what has to go further was not seen where it must
be."""
SWEEPS = 100
"""Passes over all contacts in which their forces are found."""


class Contact(NamedTuple):
    """Two bodies, by number, the lower first, and how far the second reaches into the first."""

    first: int
    second: int
    reach: Reach


def moved_apart(
    posed: Sequence[Hypothesis], information: Callable[[int], Floats], still: int = 0
) -> tuple[list[Floats], list[tuple[int, int]]]:
    """Poses (4, 4), camera_from_object, of N objects, and the pairs that still reach more than ``DEEP`` into each other.

    So do pairs that would have to move too ``FAR``. One that touches nobody keeps its pose, the same array; so do the
    first, which stand ``still``, and nothing is told of pairs of these. ``information``, (6, 6), of the pose of one by
    number (``pose_information``): what a move costs.
    """
    poses = [some.camera_from_object for some in posed]
    first = _deep(posed, poses, still)
    if not first:
        return poses, []
    costs, deep = [information(k) for k in range(len(posed))], first
    yields = [(k >= still) * np.asarray(np.linalg.inv(cost)) for k, cost in enumerate(costs)]
    for _ in range(ROUNDS):
        poses = _eased(posed, poses, yields, deep)
        deep = _deep(posed, poses, still)
        if not deep:
            break
    far = [_cost(some, pose, cost) > FAR**2 for some, pose, cost in zip(posed, poses, costs, strict=True)]
    deep += [contact for contact in first if far[contact.first] or far[contact.second]]
    return poses, sorted({(contact.first, contact.second) for contact in deep})


def _deep(posed: Sequence[Hypothesis], poses: Sequence[Floats], still: int) -> list[Contact]:
    return [contact for contact in contacts(posed, poses, still) if contact.reach.depth > DEEP]


def reaches_into(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two reach more than ``DEEP`` into each other."""
    poses = [some.camera_from_object for some in (one, other)]
    return any(contact.reach.depth > DEEP for contact in contacts((one, other), poses))


def contacts(posed: Sequence[Hypothesis], poses: Sequence[Floats], still: int = 0) -> list[Contact]:
    """Where bodies at some poses reach into each other, once a connected piece of what they share.

    Of one that is no solid nobody knows.

    Pairs of the first, which stand ``still``, are left out.
    """
    found = []
    for i, j in (pair for pair in combinations(range(len(posed)), 2) if pair[1] >= still):
        one, other = (None if (surface := posed[k].object_type.surface) is None else surface.solid for k in (i, j))
        if one is not None and other is not None:
            found += [Contact(i, j, deep) for deep in reaches(solid_of(one), poses[i], solid_of(other), poses[j])]
    return found


def pose_information(posed: Hypothesis, camera: Camera, kb: KnowledgeBase) -> Floats:
    """(6, 6) of turning about the middle, rad, and moving, m: of the matches, and of what is known of any pose (``known``)."""
    used = np.flatnonzero(posed.candidate & posed.detected)
    precision = posed.counted[used] / sigmas(posed, kb)[used] ** 2
    across = None if posed.across is None else posed.across[used]
    depth = max(float(posed.middle[2]), 1e-6)
    wide, high = camera.width / camera.f * depth, camera.height / camera.f * depth
    loose = np.array([*[LOOSE[1]] * 3, wide, high, LOOSE[0] * depth])
    return information(posed.at[used], posed.middle, precision, camera, across) + np.diag(loose**-2.0)


def _eased(
    posed: Sequence[Hypothesis], poses: list[Floats], yields: Sequence[Floats], deep: Sequence[Contact]
) -> list[Floats]:
    """The poses after the least costly moves that end the contacts, as far as these are flat: a quadratic program, by its dual.

    ``yields`` (6, 6) each: the inverse of what moves cost; 0 of what stands still.
    """
    rows = np.zeros((len(deep), 6 * len(posed)))
    wanted = np.array([contact.reach.depth - SPARE * DEEP for contact in deep])
    middles = [_middle(some, pose) for some, pose in zip(posed, poses, strict=True)]
    for row, (first, second, found) in zip(rows, deep, strict=True):
        for body, sign in ((first, -1.0), (second, 1.0)):
            lever = np.cross(found.at - middles[body], found.way)
            row[6 * body : 6 * body + 6] = sign * np.concatenate([lever, found.way])
    loose = block_diag(*yields)
    coupling, force = rows @ loose @ rows.T, np.zeros(len(deep))
    for _ in range(SWEEPS):
        for k in range(len(deep)):
            force[k] = max(0.0, force[k] + (wanted[k] - coupling[k] @ force) / coupling[k, k])
    moves = (loose @ rows.T @ force).reshape(-1, 6)
    return [_moved(pose, middle, move) for pose, middle, move in zip(poses, middles, moves, strict=True)]


def _middle(posed: Hypothesis, pose: Floats) -> Floats:
    """(3,) m, camera frame: the middle of the object at another pose."""
    moved = pose @ np.linalg.inv(posed.camera_from_object)
    return np.asarray(moved[:3, :3] @ posed.middle + moved[:3, 3])


def _cost(posed: Hypothesis, pose: Floats, cost: Floats) -> float:
    """Squared standard deviations by which a pose is off the one that the matches gave."""
    turn = Rotation.from_matrix(pose[:3, :3] @ posed.camera_from_object[:3, :3].T).as_rotvec()
    move = np.concatenate([turn, _middle(posed, pose) - posed.middle])
    return float(move @ cost @ move)


def _moved(pose: Floats, middle: Floats, move: Floats) -> Floats:
    """A pose turned about a place by ``move[:3]`` rad, and moved by ``move[3:]`` m; itself where it is not moved."""
    if not move.any():
        return pose
    turn = Rotation.from_rotvec(move[:3]).as_matrix()
    new = np.eye(4)
    new[:3, :3] = turn @ pose[:3, :3]
    new[:3, 3] = turn @ (pose[:3, 3] - middle) + middle + move[3:]
    return new
