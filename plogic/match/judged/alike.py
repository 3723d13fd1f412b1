"""Which poses of a type are one hypothesis (§8, near-duplicates)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import pose_error

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices
    from kb.clouds.cloud import ObjectType
    from plogic.facts.hypothesis import Hypothesis


SAME_ROTATION, SAME_PLACE = np.radians(6.0), 0.06
"""Two poses of a type nearer than this (radians; share of the distance) are one hypothesis (§8)."""


def same_place(object_type: ObjectType, one: Floats, other: Floats) -> bool:
    """Whether two poses of a type are within tolerance of each other, up to its symmetries (§8, near-duplicates)."""
    distance = float(np.linalg.norm(one[:3, 3]))
    middle = np.append(object_type.surface.centre if object_type.surface is not None else np.zeros(3), 1.0)
    if object_type.surface is not None and np.linalg.norm((one - other) @ middle) > 2.0 * SAME_PLACE * distance:
        return False  # symmetries keep the middle where it is
    rotation, translation = pose_error(one, other, object_type.symmetries)
    return bool(rotation < SAME_ROTATION and translation < SAME_PLACE * distance)


def distinct(scored: list[tuple[float, Hypothesis]], object_type: ObjectType) -> list[tuple[float, Hypothesis]]:
    """The first of each heap of near-duplicates (§8)."""
    kept: list[tuple[float, Hypothesis]] = []
    for worth, posed in scored:
        if not any(same_place(object_type, posed.camera_from_object, old.camera_from_object) for _, old in kept):
            kept.append((worth, posed))
    return kept


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
    limits = (near * np.linalg.norm(middle, axis=1)) ** 2
    kind = np.zeros(len(order), np.intp) if kinds is None else kinds[order]
    left = np.ones(len(order), bool)
    chosen: list[int] = []
    while left.any() and len(chosen) < most:
        i = int(left.argmax())
        chosen.append(int(order[i]))
        beside = (kind == kind[i]) & (((middle - middle[i]) ** 2).sum(axis=1) < limits)
        left &= ~(beside & (turns @ turns[i] > 1.0 + 2.0 * np.cos(turned)))
        left[i] = False
    return chosen
