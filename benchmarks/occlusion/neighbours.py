"""Conceptual neighbours: the relations between which a continuous motion leads at once, found by bisection (§3.7).

One body of a pair moves, the other stays: rigidly; across the image, each corner keeping its depth; or swelling and
shrinking in the image about a point of it. Where the relation differs between two moments the change is bisected till
the moments are ``INSTANT`` of the motion apart; a third relation in between is two changes. A change counts only if the
bodies share no volume on either side of it: bodies do not pass through each other. At a tolerance relations such as EC,
TPP and EQ last, so that a motion does not jump over them. What is found are neighbours; a pair that no motion showed
may be neighbours all the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.occlusion.bodies import CAMERA, placed
from benchmarks.occlusion.pairs import KINDS, pairs
from geometry.bodies.overlap import Solid, solid_overlap
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw, transform_points
from geometry.visibility.occlusion import PosedSurface, occlusion
from geometry.visibility.roc import converse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from geometry.visibility.roc import Roc

    Motion = Callable[[float], PosedSurface]
    Neighbours = frozenset[tuple[Roc, Roc]]

MOMENTS = 7
INSTANT = 1e-6
MOVED = tuple(kind for kind in KINDS if kind != "convex")


def neighbours(count: int, seed: int, kinds: Sequence[str] = MOVED) -> Neighbours:
    """The ordered pairs of neighbours, both ways and for both orders of the bodies, of ``count`` motions of each."""
    found: set[tuple[Roc, Roc]] = set()
    for kind in kinds:
        rng = np.random.default_rng([seed, 7, KINDS.index(kind)])
        for pair in pairs(kind, count, seed):
            for before, after in changes(pair.x, _motion(rng, pair.y)):
                one, other = converse(before), converse(after)
                found |= {(before, after), (after, before), (one, other), (other, one)}
    return frozenset(found)


def changes(still: PosedSurface, motion: Motion) -> Iterator[tuple[Roc, Roc]]:
    """What the relation changes from and to, in the course of a motion, where no volume is shared."""
    times = np.linspace(0.0, 1.0, MOMENTS)
    relations = [_at(still, motion, time) for time in times]
    for start, end, before, after in zip(times, times[1:], relations, relations[1:], strict=False):
        yield from _between(still, motion, (float(start), float(end)), (before, after))


def _between(
    still: PosedSurface, motion: Motion, when: tuple[float, float], ends: tuple[Roc, Roc]
) -> Iterator[tuple[Roc, Roc]]:
    (start, end), (before, after) = when, ends
    if before == after:
        return
    if end - start <= INSTANT:
        if _apart(still, motion(start)) and _apart(still, motion(end)):
            yield before, after
        return
    middle = (start + end) / 2
    there = _at(still, motion, middle)
    yield from _between(still, motion, (start, middle), (before, there))
    yield from _between(still, motion, (middle, end), (there, after))


def _at(still: PosedSurface, motion: Motion, time: float) -> Roc:
    return occlusion(still, motion(time), CAMERA)


def _apart(x: PosedSurface, y: PosedSurface) -> bool:
    """Whether the two share no volume.

    Of a surface that is not a manifold nothing is known, and no change is counted.
    """
    try:
        a, b = (Solid(body.vertices, body.triangles) for body in (x, y))
        return solid_overlap(a, x.camera_from_object, b, y.camera_from_object) == 0
    except GeometryError:
        return False


def _motion(rng: np.random.Generator, body: PosedSurface) -> Motion:
    points = transform_points(body.camera_from_object, body.vertices)
    kind = int(rng.integers(3))
    if kind == 0:
        return _rigid(rng, body)
    seen = points[:, :2] / points[:, 2:]
    if kind == 1:
        return _across(seen, points[:, 2:], body, rng.normal(0, 0.12, 2) * rng.choice([[1, 0], [0, 1], [1, 1]]))
    middle = seen[int(rng.integers(len(seen)))] if rng.random() < 0.5 else seen.mean(axis=0)
    return _swelling(seen, points[:, 2:], body, middle, float(rng.choice([-0.6, 0.8])))


def _rigid(rng: np.random.Generator, body: PosedSurface) -> Motion:
    way, axis = rng.normal(0, 0.6, 3), rng.normal(0, 0.3, 3)

    def at(time: float) -> PosedSurface:
        turn = rotation_from_quat_xyzw(np.array([[*(axis * time), 1.0]]))[0]
        middle = transform_points(body.camera_from_object, body.vertices).mean(axis=0)
        moved = from_rotation_translation(turn, middle + way * time) @ from_rotation_translation(np.eye(3), -middle)
        return PosedSurface(body.vertices, body.triangles, body.rays, moved @ body.camera_from_object)

    return at


def _across(
    seen: NDArray[np.float64], depth: NDArray[np.float64], body: PosedSurface, way: NDArray[np.float64]
) -> Motion:
    return lambda time: placed(np.c_[seen + way * time, np.ones(len(seen))] * depth, body.triangles)


def _swelling(
    seen: NDArray[np.float64],
    depth: NDArray[np.float64],
    body: PosedSurface,
    middle: NDArray[np.float64],
    growth: float,
) -> Motion:
    return lambda time: placed(
        np.c_[middle + (seen - middle) * (1 + growth * time), np.ones(len(seen))] * depth, body.triangles
    )
