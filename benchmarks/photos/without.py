"""Each posed type left out: what the knowledge base without it accepts in its place.

In its place: the outlines' intersection over union with the removed object is above ``OVER``, and no object of the
accepted one's own type is found there (``benchmarks.photos.score``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from benchmarks.photos.answers import Looker, photos_of
from benchmarks.photos.knowledge import known, of_types
from benchmarks.photos.score import OUTLINED, overlap_of
from benchmarks.photos.table import Report, measure_of
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from benchmarks.photos.answers import Shown
    from benchmarks.photos.score import Posed
    from benchmarks.photos.table import Measure
    from plogic.run.bop.dataset import Dataset

OVER = 0.3
SHARE = 0.02
"""Of the removed objects that may come back as another; both as the issue on real photos has them."""


def of_left_out(dataset: Dataset, name: str, kept: Path | None, seed: int, say: Callable[[str], None]) -> Report:
    """Every photo once without each type that is posed in it."""
    assert dataset.models is not None  # noqa: S101 - it has been opened as a whole dataset with models
    failures: list[dict[str, Any]] = []
    asked = 0
    with known(dataset.models, kept, seed, say) as (kb, numbers):
        measure, photos = measure_of(kb, numbers, dataset.models), list(photos_of(dataset))
        for number in sorted({truth.obj_id for shown in photos for truth in shown.truths}):
            removed = measure.names[number]
            looker = Looker(of_types(kb, set(numbers) - {removed}), numbers)
            for shown in photos:
                truths = [truth for truth in shown.truths if truth.obj_id == number]
                if not truths:
                    continue
                found = in_place(looker.answer(shown, measure.models).ours, truths, shown, measure)
                asked += len(truths)
                failures += [{"of": name, "photo": shown.name, "without": removed, **one} for one in found]
                said = ", ".join(f"{one['accepted']} ({one['overlap']:.2f})" for one in found) or "nothing"
                say(f"photo {shown.name} without {removed}: {said} in its place")
    places = {(one["photo"], one["without"]) for one in failures}
    rows = [{"row": name, "left out": asked, "another in its place": len(places)}]
    share = len(places) / max(asked, 1)
    return Report(rows, {"in its place": failures}, [Claim(f"{name}: come back as another, share", "<=", SHARE, share)])


def in_place(answers: tuple[Posed, ...], removed: list[Posed], shown: Shown, measure: Measure) -> list[dict[str, Any]]:
    """What was accepted in the place of a removed object, with the overlap of their outlines."""

    def over(one: Posed, other: Posed) -> float:
        return overlap_of(one, other, measure.surfaces[one.obj_id], shown.camera, measure.surfaces[other.obj_id])

    rows = []
    for answer in answers:
        overlap = max(over(answer, truth) for truth in removed)
        own = [truth for truth in (*shown.truths, *shown.hidden) if truth.obj_id == answer.obj_id]
        if overlap > OVER and not any(over(answer, truth) >= OUTLINED for truth in own):
            rows.append({"accepted": measure.names[answer.obj_id], "overlap": round(overlap, 3)})
    return rows
