"""Two hypotheses in one place: near-duplicates (§8), rivals (§3.1, §4.1), and bodies that are moved apart (A4).

Rivalry by claims is decided in the world that holds just the two: what one hides of the other is not expected there and
claims nothing. Otherwise a window of the tower in front, taken for a hidden window of the tower behind, would make
rivals of two towers that both stand.

A4 holds to a millimetre: objects that reach into each other by no more than poses are wrong are moved apart, all
together. Of all poses that keep them apart those are taken for which Γ speaks most: each pose's information, from its
matches, tells what a move costs.

* ``same_place``, ``Places``, ``distinct``, ``apart``: which poses of a type are one hypothesis
* ``excludes(one, other)``: whether no world holds both; ``overlap``, ``shared_claims``: by volume, by data
* ``moved_apart(posed, information)``: the poses, and which pairs still reach into each other
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import lru_cache
from itertools import combinations, islice
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from geometry.bodies.overlap import Reach, Solid, reaches, solid_overlap
from geometry.frames import inverse, pose_error, transform_points
from kb.clouds.cloud import ObjectType
from kb.surfaces.surface import Surface
from plogic.facts.hypothesis import Hypothesis
from plogic.match.judged.expectation import hidden_by

SAME_ROTATION, SAME_PLACE = np.radians(6.0), 0.06
"""Two poses of a type nearer than this (radians; share of the distance) are one hypothesis (§8)."""


def same_place(object_type: ObjectType, one: Floats, other: Floats) -> bool:
    """Whether two poses of a type are within tolerance of each other, up to its symmetries (§8, near-duplicates)."""
    return bool(same_places(object_type, one, other[None])[0])


def same_places(object_type: ObjectType, one: Floats, others: Floats) -> Mask:
    """Whether a pose of a type is in the place of each of others (N, 4, 4)."""
    distance = float(np.linalg.norm(one[:3, 3]))
    same = np.ones(len(others), bool)
    if object_type.surface is not None:  # symmetries keep the middle where it is
        gaps = np.linalg.norm((one - others) @ np.append(object_type.surface.centre, 1.0), axis=-1)
        same = np.asarray(~(gaps > 2.0 * SAME_PLACE * distance))
    if same.any():
        rotation, translation = pose_error(one, others[same], object_type.symmetries)
        same[same] = (rotation < SAME_ROTATION) & (translation < SAME_PLACE * distance)
    return same


class Places:
    """Poses of a type, no two of them in one place."""

    def __init__(self, object_type: ObjectType) -> None:
        """There is none yet."""
        self._object_type, self._poses, self._count = object_type, np.empty((8, 4, 4)), 0

    def add(self, pose: Floats) -> bool:
        """Add a pose (4, 4), and whether its place was free; else nothing changes."""
        if same_places(self._object_type, pose, self._poses[: self._count]).any():
            return False
        if self._count == len(self._poses):
            self._poses = np.concatenate([self._poses, np.empty_like(self._poses)])
        self._poses[self._count] = pose
        self._count += 1
        return True


EVEN = 6
"""Decimals of evidence to which equal hypotheses, as of a symmetric body, are equal: the first of them counts."""


def distinct(scored: Iterable[tuple[float, Hypothesis]], object_type: ObjectType) -> list[tuple[float, Hypothesis]]:
    """The best of each heap of near-duplicates (§8), best first."""
    places = Places(object_type)
    best_first = sorted(scored, key=lambda pair: -round(pair[0], EVEN))
    return [(worth, posed) for worth, posed in best_first if places.add(posed.camera_from_object)]


def distinct_poses(object_type: ObjectType, poses: Iterable[Floats], most: int) -> list[Floats]:
    """The first ``most`` of poses (4, 4) that are not at one place, up to symmetry."""
    places = Places(object_type)
    return list(islice((pose for pose in poses if places.add(pose)), most))


def apart(
    poses: Floats,
    middles: Floats,
    worth: Floats,
    most: int,
    alike: tuple[float, float],
    kinds: Indices | None = None,
) -> list[int]:
    """The best of coarse poses (N, 4, 4) by worth (N,), at most so many, no two alike.

    ``middles`` (N, 3) of the objects, camera frame.

    ``alike``: radians, and share of the distance, by less than which two differ that are; ``kinds`` (N,): none is alike
    one of another kind.
    """
    turned, near = alike
    order = np.argsort(-worth, kind="stable")
    middle, turns = middles[order], poses[order, :3, :3].reshape(-1, 9)
    kind = np.zeros(len(order), np.intp) if kinds is None else kinds[order]
    limits = (near * np.linalg.norm(middle, axis=1)) ** 2
    rows = (np.flatnonzero(kind == one) for one in np.unique(kind))
    of_kind = {kind[own[0]]: (own, limits[own], *middle[own].T.copy()) for own in rows}
    left = np.ones(len(order), bool)
    chosen: list[int] = []
    for i in range(len(order)):
        if len(chosen) == most:
            break
        if left[i]:
            chosen.append(int(order[i]))
            own, limit, x, y, z = of_kind[kind[i]]
            beside = own[(x - middle[i, 0]) ** 2 + (y - middle[i, 1]) ** 2 + (z - middle[i, 2]) ** 2 < limit]
            left[beside[turns[beside] @ turns[i] > 1.0 + 2.0 * np.cos(turned)]] = False
    return chosen


SHARED_VOLUME = 0.02
"""Share of the smaller volume that two estimated poses may have in common before A4 counts as violated: what 2 % of
pose error makes."""
SHARED_CLAIMS = 0.5
"""Share of the smaller claim, in appearances, above which two hypotheses explain the same data, so that only one can be
present."""


@lru_cache(maxsize=256)
def solid_of(surface: Surface) -> Solid:
    """The volume of a type's closed surface, built once a type."""
    return Solid(surface.vertices, surface.triangles)


def overlap(one: Hypothesis, other: Hypothesis, most: float = SHARED_VOLUME) -> bool:
    """A4: whether the two bodies share volume beyond what pose errors make of touching ones: more than this share.

    Of one that is no solid nobody knows.
    """
    a, b = one.object_type.surface, other.object_type.surface
    if a is None or b is None or np.linalg.norm(_middle(one, a) - _middle(other, b)) >= 0.5 * (a.diameter + b.diameter):
        return False
    if a.solid is None or b.solid is None:  # refused (kb.surfaces.surface)
        return False
    volume = _shared(a.solid, one.camera_from_object.tobytes(), b.solid, other.camera_from_object.tobytes())
    return bool(volume > most * min(a.solid.volume, b.solid.volume))


@lru_cache(maxsize=4096)
def _shared(first: Surface, pose: bytes, second: Surface, other: bytes) -> float:
    """The volume that two posed bodies share, m³; the cycle asks it of the same pair again and again."""
    one, two = (np.frombuffer(some).reshape(4, 4) for some in (pose, other))
    return solid_overlap(solid_of(first), one, solid_of(second), two)


def hidden_among(posed: Hypothesis, others: Sequence[Hypothesis]) -> Mask:
    """(F,) what opaque others hide of a hypothesis; those that A4 excludes beside it hide nothing (D7)."""
    hidden = np.zeros(len(posed.uv), bool)
    for other in others:
        if other is not posed and other.object_type.opaque and not overlap(posed, other):
            hidden |= hidden_by(posed, other)
    return hidden


def apart_on_screen(one: Hypothesis, other: Hypothesis, f: float, margin: float) -> bool:
    """Whether the balls around two bodies stand more than ``margin`` pixels apart in the image (focal length ``f``).

    Then neither hides anything of the other, shares volume with it, or takes data that it might take.
    """
    spans = []
    for posed in (one, other):
        surface = posed.object_type.surface
        if surface is None:
            return False
        middle, radius = _middle(posed, surface), 0.5 * surface.diameter
        if middle[2] <= 2.0 * radius:
            return False
        spans.append(
            (middle[:2] / middle[2] * f, f * radius * np.linalg.norm(middle) / (middle[2] * (middle[2] - radius)))
        )
    (first, a), (second, b) = spans
    return bool(np.linalg.norm(first - second) > a + b + margin)


def _middle(posed: Hypothesis, surface: Surface) -> Floats:
    """The middle (3,) of the posed bounding box, camera frame."""
    return np.asarray(posed.camera_from_object[:3, :3] @ surface.centre + posed.camera_from_object[:3, 3])


def claims(posed: Hypothesis, beside: Hypothesis | None = None) -> dict[int, float]:
    """The data that its expected features take, with the residual in pixels; ``beside`` stands in the same world."""
    mine = posed.candidate & posed.detected
    if beside is not None and beside.object_type.opaque:
        mine = mine & ~hidden_by(posed, beside)
    return {int(posed.matches[f]): float(posed.residual[f]) for f in np.flatnonzero(mine)}


def shared_claims(one: Hypothesis, other: Hypothesis) -> tuple[set[int], float]:
    """The data that both claim in their common world, and their share of the smaller claim."""
    mine, theirs = claims(one, other), claims(other, one)
    both = mine.keys() & theirs.keys()
    return both, len(both) / max(1, min(len(mine), len(theirs)))


def excludes(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether no world holds both: A4, or they explain the same data."""
    return overlap(one, other) or shared_claims(one, other)[1] > SHARED_CLAIMS


def in_the_way(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether it stands in the place of another, by what excludes both, or hides most of what that shows."""
    return excludes(one, other) or hides_most(one, other)


def hides_most(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether another hides most of what it shows."""
    shown = one.candidate
    return bool((hidden_by(one, other) & shown).sum() > SHARED_CLAIMS * max(1, shown.sum()))


DEEP = 0.001
"""Metres by which two accepted objects may reach into each other."""
SPARE = 0.1
"""Share of that which is left when they are moved."""
ROUNDS = 12
"""Times that contacts are looked for: what was found before is held, and bodies that are moved meet others."""
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
    posed: Sequence[Hypothesis],
    information: Callable[[int], Floats],
    still: int = 0,
    through: Collection[tuple[int, int]] = (),
    far: float = FAR,
) -> tuple[list[Floats], list[tuple[int, int]]]:
    """Poses (4, 4), camera_from_object, of N objects, and the pairs that still reach more than ``DEEP`` together.

    So do pairs that would have to move too ``far``. One that touches nobody keeps its pose, the same array; so do the
    first, which stand ``still``, and nothing is told of pairs of these. ``information``, (6, 6), of the pose of one by
    number (``pose_information``): what a move costs. The pairs ``through`` leave each other by the far side.
    """
    poses = [some.camera_from_object for some in posed]
    first = deep = _deep(posed, poses, still)
    if not first:
        return poses, []
    from scipy.linalg import block_diag

    costs = [information(k) for k in range(len(posed))]
    loose = block_diag(*((k >= still) * np.asarray(np.linalg.inv(cost)) for k, cost in enumerate(costs)))
    moves, rows, wanted = np.zeros(6 * len(posed)), np.zeros((0, 6 * len(posed))), np.zeros(0)
    far_ways = {(one.first, one.second): -one.reach.way for one in deep if (one.first, one.second) in through}
    for _ in range(ROUNDS):
        sided = [_sided(posed, poses, one, far_ways.get((one.first, one.second))) for one in deep]
        new = _rows(posed, poses, sided)
        depths = np.array([contact.reach.depth - SPARE * DEEP for contact in sided])
        rows, wanted = np.vstack([rows, new]), np.concatenate([wanted, new @ moves + depths])
        moves = _least(rows, wanted, loose)
        poses = [
            _moved(h.camera_from_object, h.middle, move) for h, move in zip(posed, moves.reshape(-1, 6), strict=True)
        ]
        deep = _deep(posed, poses, still)
        if not deep:
            break
    lost = [_cost(some, pose, cost) > far**2 for some, pose, cost in zip(posed, poses, costs, strict=True)]
    deep += [contact for contact in first if lost[contact.first] or lost[contact.second]]
    return poses, sorted({(contact.first, contact.second) for contact in deep})


def _deep(posed: Sequence[Hypothesis], poses: Sequence[Floats], still: int) -> list[Contact]:
    return [contact for contact in contacts(posed, poses, still) if contact.reach.depth > DEEP]


def reaches_into(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two reach more than ``DEEP`` into each other."""
    return bool(_deep((one, other), [one.camera_from_object, other.camera_from_object], 0))


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


def _sided(posed: Sequence[Hypothesis], poses: Sequence[Floats], contact: Contact, far: Floats | None) -> Contact:
    """The contact as it ends along ``far`` (3,): through both bodies, as thick as they are on the line through it.

    Itself where it ends that way, where no way is asked for, and where a body is not met there.
    """
    way, at = contact.reach.way, contact.reach.at
    if far is None or way @ far >= 0.0:
        return contact
    ends = []
    for k, side in ((contact.first, -1.0), (contact.second, 1.0)):
        surface = posed[k].object_type.surface
        if surface is None:
            return contact
        object_from_camera, out = inverse(poses[k]), side * 4.0 * surface.diameter
        start = transform_points(object_from_camera, (at + out * way)[None])
        ends.append(out - side * surface.rays.first_hit(start, -side * (object_from_camera[:3, :3] @ way)[None])[0])
    depth = ends[1] - ends[0]
    return contact._replace(reach=Reach(float(depth), -way, at)) if np.isfinite(depth) else contact


def _rows(posed: Sequence[Hypothesis], poses: Sequence[Floats], deep: Sequence[Contact]) -> Floats:
    """(C, 6 N) by how much a small move of each body, rad and m, lessens how far the two of each contact reach."""
    rows = np.zeros((len(deep), 6 * len(posed)))
    middles = [_moved_middle(some, pose) for some, pose in zip(posed, poses, strict=True)]
    for row, (first, second, found) in zip(rows, deep, strict=True):
        for body, sign in ((first, -1.0), (second, 1.0)):
            lever = np.cross(found.at - middles[body], found.way)
            row[6 * body : 6 * body + 6] = sign * np.concatenate([lever, found.way])
    return rows


def _least(rows: Floats, wanted: Floats, loose: Floats) -> Floats:
    """(6 N,) the least costly moves x with ``rows`` x ≥ ``wanted``: a quadratic program, by its dual.

    ``loose`` (6 N, 6 N): the inverse of what moves cost; 0 of what stands still.
    """
    coupling, force = rows @ loose @ rows.T, np.zeros(len(rows))
    for _ in range(SWEEPS):
        for k in range(len(rows)):
            force[k] = max(0.0, force[k] + (wanted[k] - coupling[k] @ force) / coupling[k, k])
    return np.asarray(loose @ rows.T @ force)


def _moved_middle(posed: Hypothesis, pose: Floats) -> Floats:
    """(3,) m, camera frame: the middle of the object at another pose."""
    moved = pose @ np.linalg.inv(posed.camera_from_object)
    return np.asarray(moved[:3, :3] @ posed.middle + moved[:3, 3])


def _cost(posed: Hypothesis, pose: Floats, cost: Floats) -> float:
    """Squared standard deviations by which a pose is off the one that the matches gave."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(pose[:3, :3] @ posed.camera_from_object[:3, :3].T).as_rotvec()
    move = np.concatenate([turn, _moved_middle(posed, pose) - posed.middle])
    return float(move @ cost @ move)


def _moved(pose: Floats, middle: Floats, move: Floats) -> Floats:
    """A pose turned about a place by ``move[:3]`` rad, and moved by ``move[3:]`` m; itself where it is not moved."""
    if not move.any():
        return pose
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(move[:3]).as_matrix()
    new = np.eye(4)
    new[:3, :3] = turn @ pose[:3, :3]
    new[:3, 3] = turn @ (pose[:3, 3] - middle) + middle + move[3:]
    return new
