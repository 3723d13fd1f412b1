"""One photo's answers against its truth: who is right, who is found, what was accepted falsely.

* ``There``: an object that is there; ``Answered``: one that was accepted
* ``right``: ADD, of symmetric types ADD-S, below a tenth of the diameter; ``found``: outlines' intersection over union
  at least 0.7 (within the picture; depth within half as much again)
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.visibility.rays import depth_of
from plogic.run.bop.recalls import add, add_s

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from geometry.arrays import Floats
    from geometry.camera import Camera
    from geometry.visibility.rays import RayMesh
    from plogic.run.bop.models import Model

RIGHT = 0.1
"""Diameters of ADD or ADD-S below which a pose is right."""
OUTLINED = 0.7
"""Intersection over union of the outlines from which it is found."""
POINTS = 1000
"""Of a model, evenly chosen, that errors are taken over."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A type by its BOP number, and ``camera_from_object`` (4, 4)."""

    obj_id: int
    camera_from_object: Floats


class Told(NamedTuple):
    """A truth's number, and its error, overlap and ``answer``; None where nothing of its type stands for it."""

    obj_id: int
    error: float | None = None
    overlap: float | None = None
    answer: Posed | None = None

    @property
    def right(self) -> bool:
        """Whether the pose that stands for it is."""
        return self.error is not None and self.error < RIGHT

    @property
    def found(self) -> bool:
        """Whether its outline is, or its pose is right."""
        return self.right or (self.overlap is not None and self.overlap >= OUTLINED)


@dataclass(frozen=True)
class Counts:
    """Objects there; of them right, found, and with an accepted one of their type; accepted of types not there."""

    there: int = 0
    right: int = 0
    found: int = 0
    accepted: int = 0
    false: int = 0

    def __add__(self, other: Counts) -> Counts:
        """Of both together."""
        return Counts(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @property
    def precision(self) -> float:
        """Share of what was accepted that is found; 1 of none."""
        return self.found / (self.accepted + self.false) if self.accepted + self.false else 1.0


def error_of(answer: Posed, truth: Posed, model: Model) -> float:
    """ADD, of a symmetric model ADD-S, in diameters."""
    points = model.points[:: max(1, len(model.points) // POINTS)]
    measure = add_s if model.symmetric else add
    one, other = (some.camera_from_object[None] for some in (answer, truth))
    return float(np.ravel(measure(one, other, points))[0]) / model.diameter


def depth_error(answer: Posed, truth: Posed, model: Model) -> float:
    """By how much the depth of the model's middle is off, metres."""
    middle = model.points.mean(axis=0)
    one, other = (pose.camera_from_object[2, :3] @ middle + pose.camera_from_object[2, 3] for pose in (answer, truth))
    return float(abs(one - other))


def overlap_of(
    answer: Posed, truth: Posed, surface: RayMesh, camera: Camera, other_surface: RayMesh | None = None
) -> float:
    """Intersection over union of the outlines, whole, whatever hides them.

    ``other_surface``: the truth's, where it is of another type.
    """
    size = camera.width, camera.height
    pairs = (surface, answer), (other_surface or surface, truth)
    one, other = (np.isfinite(depth_of(own, some.camera_from_object, camera.K, size)) for own, some in pairs)
    return float((one & other).sum() / max(int((one | other).sum()), 1))


def asked(
    answers: Sequence[Posed], truths: Sequence[Posed], hidden: Sequence[Posed], models: Mapping[int, Model]
) -> tuple[Posed, ...]:
    """The answers but those that stand for an object that is too ``hidden`` to be asked for: nearer to it by ADD."""

    def nearest(answer: Posed, some: Sequence[Posed]) -> float:
        own = [one for one in some if one.obj_id == answer.obj_id]
        return min((error_of(answer, one, models[one.obj_id]) for one in own), default=np.inf)

    return tuple(a for a in answers if nearest(a, hidden) >= nearest(a, truths))


def counted(
    answers: Sequence[Posed],
    truths: Sequence[Posed],
    unposed: Collection[int],
    models: Mapping[int, Model],
    surfaces: Mapping[int, RayMesh],
    camera: Camera,
) -> tuple[Counts, list[Told]]:
    """One photo's counts; and of each truth what stands for it.

    Each answer stands for the nearest truth of its type (ADD) at most. ``unposed``: types that are there without a
    pose: what is accepted of them is neither right nor false.
    """
    rows: list[Told] = []
    errors = {
        id(answer): [error_of(answer, t, models[t.obj_id]) if t.obj_id == answer.obj_id else np.inf for t in truths]
        for answer in answers
    }
    for i, truth in enumerate(truths):
        own = [a for a in answers if errors[id(a)][i] < np.inf and np.argmin(errors[id(a)]) == i]
        best = min(own, key=lambda answer: errors[id(answer)][i], default=None)
        if best is None:
            rows.append(Told(truth.obj_id))
            continue
        error = errors[id(best)][i]
        overlap = overlap_of(best, truth, surfaces[truth.obj_id], camera)
        rows.append(Told(truth.obj_id, error, overlap, best))
    posed = {truth.obj_id for truth in truths}
    accepted = sum(answer.obj_id in posed for answer in answers)
    false = sum(answer.obj_id not in posed and answer.obj_id not in unposed for answer in answers)
    right, found = sum(row.right for row in rows), sum(row.found for row in rows)
    return Counts(len(truths), right, found, accepted, false), rows
