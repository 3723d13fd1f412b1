"""What support is worth on real photos: the plane found against that of the true poses, and what is found without it.

* ``Side``: answers with support, or without; ``true_plane``: the plane of a photo's true poses
* ``of_support``: the rows and claims of a dataset, perceived with support and without
"""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from benchmarks.photos.score import depth_error
from benchmarks.shared.claims import Claim
from plogic.cycle.planes import Setting, bodies_of, supported
from plogic.facts.hypothesis import Hypothesis

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from benchmarks.photos.answers import Answer, Shown
    from benchmarks.photos.table import Measure
    from geometry.bodies.resting import Plane
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.judged.type_models import TypeModel

SURE = 50.0
"""Log-odds of what is there."""
TURNED, OFF = 7.0, 80.0
"""Degrees and millimetres within which a plane is right, and in how many of ``lmo`` it is to be."""
PLANES = {"lmo": 10}
DEEPER = {"ycb": 0.7}
"""Of the depth error without support, at most."""
NOT_MISSED = {"lmo": 1 / 3}
"""Share of what is missed without support that is to be found with it."""


class Side(NamedTuple):
    """Answers to all photos, with support or without."""

    answers: Sequence[Answer]
    measure: Measure

    def found(self) -> set[tuple[str, int]]:
        """Photo and type of what is found."""
        rows = ((a.shown.name, told) for a in self.answers for told in self.measure.counted(a.shown, a.ours)[1])
        return {(name, told.obj_id) for name, told in rows if told.found}

    def depths(self) -> dict[tuple[str, int], float]:
        """By how much the depth of each found one is off, metres."""
        errors = {}
        for a in self.answers:
            for truth, told in zip(a.shown.truths, self.measure.counted(a.shown, a.ours)[1], strict=True):
                if told.found and told.answer is not None:
                    model = self.measure.models[truth.obj_id]
                    errors[a.shown.name, truth.obj_id] = depth_error(told.answer, truth, model)
        return errors


def true_bodies(shown: Shown, names: Mapping[int, str], models: Mapping[str, TypeModel]) -> list[Hypothesis]:
    """The true poses of a photo, of known types, as hypotheses that are sure."""
    return [
        Hypothesis(names[some.obj_id], some.camera_from_object, opaque=True, surplus=SURE, pixels=SURE)
        for some in shown.truths
        if names.get(some.obj_id) in models
    ]


def true_plane(
    shown: Shown, names: Mapping[int, str], models: Mapping[str, TypeModel], kb: KnowledgeBase
) -> Plane | None:
    """The plane that the true poses of a photo speak for; None of fewer than two."""
    truths = true_bodies(shown, names, models)
    if len(truths) < 2 or kb.rests is None:
        return None
    planes = supported(bodies_of(truths, [], Setting(models, shown.camera, kb)), kb.rests).planes
    return planes[0].known.plane if planes else None


def off(plane: Plane, true: Plane) -> tuple[float, float]:
    """Degrees between two planes, and millimetres between their distances from the camera."""
    return float(np.degrees(plane.turned(true))), 1000.0 * (plane.offset - true.offset)


def of_support(
    name: str, with_it: Side, without: Side, true: Mapping[str, Plane | None]
) -> tuple[list[dict[str, Any]], list[Claim]]:
    """A row a photo of its first plane, and the claims of a dataset; ``true``: planes by photo."""
    rows: list[dict[str, Any]] = []
    right = 0
    for a in with_it.answers:
        plane, there = a.plane, true[a.shown.name]
        if there is not None:
            turned, gap = (None, None) if plane is None else off(plane, there)
            good = turned is not None and gap is not None and turned <= TURNED and abs(gap) <= OFF
            right += good
            rows.append({"photo": a.shown.name, "degrees": turned, "mm": gap, "right": good})
    claims = []
    if name in PLANES:
        claims.append(Claim(f"{name}: plane first within 7 degrees and 80 mm", ">=", PLANES[name], right))
    now, before = with_it.found(), without.found()
    missed = {(a.shown.name, some.obj_id) for a in without.answers for some in a.shown.truths} - before
    share = len(now & missed) / max(len(missed), 1)
    if name in NOT_MISSED:
        claims.append(Claim(f"{name}: found of what is missed without support", ">=", NOT_MISSED[name], share))
    deep, deep_before = with_it.depths(), without.depths()
    both = [key for key in deep if key in deep_before and true[key[0]] is not None]
    if both and name in DEEPER:
        ratio = median(deep[key] for key in both) / median(deep_before[key] for key in both)
        claims.append(Claim(f"{name}: median depth error, of that without support", "<=", DEEPER[name], ratio))
        claims.append(Claim(f"{name}: found without support and lost with it", "<=", 0, len(before - now)))
    return rows, claims
