"""Which hypotheses of a scene are true: the one place where that is defined.

A hypothesis is true if an object of its type stands at its pose, up to symmetry, within the tolerance by which
near-duplicates are merged (§8). An object makes one hypothesis true at most, the one whose pose is nearest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import pose_error
from plogic.match.judged.rivals import SAME_PLACE, SAME_ROTATION, same_place

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType
    from plogic.rates.scene_records import TrueObject

    Hypotheses = Mapping[str, tuple[ObjectType, NDArray[np.float64]]]


def true_ones(hypotheses: Hypotheses, objects: Sequence[TrueObject]) -> frozenset[str]:
    """The ids of the true ones; each hypothesis is a type and its camera_from_object (4, 4)."""
    off = sorted(
        (_apart(kind, pose, o), name, i)
        for name, (kind, pose) in hypotheses.items()
        for i, o in enumerate(objects)
        if o.label == kind.name and same_place(kind, pose, o.camera_from_object)
    )
    true: dict[str, int] = {}
    for _, name, i in off:
        if name not in true and i not in true.values():
            true[name] = i
    return frozenset(true)


def _apart(kind: ObjectType, pose: NDArray[np.float64], true: TrueObject) -> float:
    """Rotation and translation, each as a share of what is tolerated."""
    turned, moved = pose_error(pose, true.camera_from_object, kind.symmetries)
    return float(turned) / SAME_ROTATION + float(moved) / (
        SAME_PLACE * float(np.linalg.norm(true.camera_from_object[:3, 3]))
    )
