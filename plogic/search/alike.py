"""Which poses of a type are one hypothesis (§8, near-duplicates)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import pose_error

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.cloud import ObjectType
    from plogic.expectation import Posed

SAME_ROTATION, SAME_PLACE = np.radians(6.0), 0.06
"""Two poses of a type nearer than this (radians; share of the distance) are one hypothesis (§8)."""


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
