"""Recalls of BOP against ground truth.

Hodaň et al., BOP Challenge 2020 (§2.3): a measure's average recall is the mean of the recalls at ten thresholds:
AR_MSSD at 0.05, 0.10 … 0.50 of the object's diameter, AR_MSPD at 5, 10 … 50 px · r with r = width / 640. The
challenge's AR is the mean of AR_VSD, AR_MSSD and AR_MSPD; AR_VSD is not computed here, so that what is given beside
them is called the mean of the two and never AR. ADD(-S): recall at 0.1 of the diameter, by ADD-S for objects with
symmetries and by ADD for the others.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from plogic.run.bop.matching import matched, taken, targets_of
from plogic.run.bop.pose_errors import add, add_s, mspd, mssd

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from plogic.run.bop.dataset import Truth
    from plogic.run.bop.matching import View
    from plogic.run.bop.models import Model
    from plogic.run.bop.results_file import Estimate

TENTHS = np.arange(1, 11)
THRESHOLDS = {"MSSD": 0.05 * TENTHS, "MSPD": 5.0 * TENTHS, "ADD": np.array([0.1])}
"""MSSD and ADD(-S) by the diameter, MSPD in pixels of an image 640 wide."""
WIDTH = 640.0


@dataclass(frozen=True)
class Recalls:
    """Recalls over ``targets`` instances, None where there are none."""

    targets: int
    ar_mssd: float | None
    ar_mspd: float | None
    add: float | None

    @property
    def mean_of_the_two(self) -> float | None:
        """The mean of AR_MSSD and AR_MSPD: not BOP's AR, which has AR_VSD as well."""
        return None if self.ar_mssd is None or self.ar_mspd is None else (self.ar_mssd + self.ar_mspd) / 2


@dataclass(frozen=True)
class Scores:
    """All objects together and one by one. ``estimates``: all that were made. ``absent``: of these, of objects that are not in their image."""

    images: int
    estimates: int
    absent: int
    together: Recalls
    objects: Mapping[int, Recalls] = field(default_factory=dict)


def score(views: Iterable[View], models: Mapping[int, Model]) -> Scores:
    """The scores of all views; ``models`` has every object that is wanted in any."""
    targets: Counter[int] = Counter()
    hits: dict[str, Counter[tuple[int, int]]] = {name: Counter() for name in THRESHOLDS}
    images = estimates = absent = 0
    for view in views:
        there = {truth.obj_id for truth in view.truths}
        images, estimates = images + 1, estimates + len(view.estimates)
        absent += sum(e.obj_id not in there for e in view.estimates)
        for obj_id, truths in targets_of(view).items():
            targets[obj_id] += len(truths)
            found = taken(view, obj_id, len(truths))
            for name, table in _errors(found, truths, models[obj_id], view).items():
                for i, threshold in enumerate(THRESHOLDS[name]):
                    hits[name][obj_id, i] += len(matched(table, float(threshold)))
    rows = {obj_id: _recalls([obj_id], targets, hits) for obj_id in sorted(targets)}
    return Scores(images, estimates, absent, _recalls(sorted(targets), targets, hits), rows)


def _errors(
    found: Sequence[Estimate], truths: Sequence[Truth], model: Model, view: View
) -> dict[str, NDArray[np.float64]]:
    """(E, G) by measure, as the thresholds mean them; nothing without an estimate."""
    if not found or view.camera is None:
        return {}
    a = np.array([e.camera_from_object for e in found])[:, None]
    b = np.array([t.camera_from_object for t in truths])[None]
    distance = add_s if model.symmetric else add
    return {
        "MSSD": mssd(a, b, model.points, model.symmetries) / model.diameter,
        "MSPD": mspd(a, b, model.points, model.symmetries, view.camera.K) * WIDTH / view.camera.width,
        "ADD": distance(a, b, model.points) / model.diameter,
    }


def _recalls(ids: Sequence[int], targets: Mapping[int, int], hits: Mapping[str, Counter[tuple[int, int]]]) -> Recalls:
    """Recall over the instances of these objects together, averaged over each measure's thresholds."""
    wanted = sum(targets[obj_id] for obj_id in ids)
    if not wanted:
        return Recalls(0, None, None, None)

    def average(name: str) -> float:
        count = len(THRESHOLDS[name])
        return sum(hits[name][obj_id, i] for obj_id in ids for i in range(count)) / (wanted * count)

    return Recalls(wanted, average("MSSD"), average("MSPD"), average("ADD"))
