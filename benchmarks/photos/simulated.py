"""Rendered pictures with the troubles of photos (``benchmarks.photos.scenes``): found, right, and calibrated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.photos import told
from benchmarks.photos.answers import Looker
from benchmarks.photos.knowledge import known, of_types
from benchmarks.photos.scenes import PLAIN, PRINTED, as_symmetric, photos, shapes_of
from benchmarks.photos.table import Report, draw, measure_of, row, seconds_of, wrong
from benchmarks.shared.claims import Claim
from geometry.frames import transform_points
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from benchmarks.photos.answers import Answer
    from benchmarks.photos.table import Measure
    from plogic.run.bop.dataset import Dataset

GROUPS = {"printed": PRINTED, "plain": PLAIN}
RIGHT = {"printed": 0.95, "plain": 0.6}
SIZES = 40, 80, 120, 200, 400
"""Pixels between which objects are counted apart, by the longer side of their picture."""
PRECISION, CALIBRATED = 0.98, 0.03
"""What the issue on real photos asks for."""


def of_pictures(
    dataset: Dataset,
    name: str,
    kept: Path | None,
    seed: int,
    count: int,
    say: Callable[[str], None],
    pictures: Path | None,
) -> Report:
    """``count`` pictures of the models of a dataset; its types with and without print alone are in the knowledge base.

    Raises InputError where it has none of these types.
    """
    assert dataset.models is not None  # noqa: S101 - it has been opened as a whole dataset with models
    answers = []
    with known(dataset.models, kept, seed, say) as (kb, numbers):
        whole = measure_of(kb, numbers, dataset.models)
        mine = [number for group in GROUPS.values() for number in group if number in whole.models]
        if not mine:
            raise InputError(f"{dataset.models}: has none of the types {', '.join(map(str, (*PRINTED, *PLAIN)))}")
        measure = whole._replace(models=as_symmetric(whole.models))
        looker = Looker(of_types(kb, {measure.names[number] for number in mine}), numbers)
        for shown in photos(shapes_of(dataset.models, mine), count, seed):
            answers.append(looker.answer(shown, measure.models))
            say(answers[-1].said(measure.names))
    if pictures is not None:
        draw(measure, answers, "simulated", pictures)
    totals = {group: measure.total(((a.shown, a.ours) for a in answers), own) for group, own in GROUPS.items()}
    every = measure.total((a.shown, a.ours) for a in answers)
    claimed = [f for a in answers for f in a.told]
    claims = [
        *(
            Claim(f"{g}: right, share of {c.there}", ">=", RIGHT[g], c.right / max(c.there, 1))
            for g, c in totals.items()
        ),
        Claim("precision", ">=", PRECISION, every.precision),
        *told.claims("simulated", claimed, CALIBRATED),
    ]
    rows = [row(f"{name}, {group}", counts, seconds_of(answers)) for group, counts in (*totals.items(), ("all", every))]
    more = {
        "right by size": by_size(measure, answers),
        "not right": wrong(measure, answers),
        "claimed": told.rows("simulated", claimed),
        "reliability": told.bins("simulated", claimed),
    }
    return Report(rows, more, claims)


def by_size(measure: Measure, answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """How many objects are there, and how many right, by how large they are seen."""
    seen: dict[tuple[int, str], list[bool]] = {}
    for a in answers:
        for truth, one in zip(a.shown.truths, measure.counted(a.shown, a.ours)[1], strict=True):
            places = transform_points(truth.camera_from_object, measure.surfaces[truth.obj_id].vertices)
            pixels = float(np.ptp(a.shown.camera.project(places), axis=0).max())
            group = next(group for group, own in GROUPS.items() if truth.obj_id in own)
            band = int(np.searchsorted(SIZES[1:-1], pixels, side="right"))
            seen.setdefault((band, group), []).append(one.right)
    return [
        {"pixels": f"{SIZES[band]} to {SIZES[band + 1]}", "of": group, "there": len(right), "right": sum(right)}
        for (band, group), right in sorted(seen.items())
    ]
