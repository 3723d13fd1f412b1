"""What ``plogic bench photos`` prints of answers: counts, what is not right, and a picture of each photo."""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from benchmarks.photos.score import Counts, Told, asked, counted
from plogic.run.bop.models import read_models

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence
    from pathlib import Path

    from benchmarks.photos.answers import Answer, Shown
    from benchmarks.photos.score import Posed
    from benchmarks.photos.told import Forecast
    from benchmarks.shared.claims import Claim
    from geometry.visibility.rays import RayMesh
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.bop.models import Model


class Report(NamedTuple):
    """Of one dataset: the rows, further tables by name, the claims, and what documents claimed, with the outcome."""

    rows: list[dict[str, Any]]
    more: dict[str, list[dict[str, Any]]]
    claims: list[Claim]
    told: tuple[Forecast, ...] = ()


class Measure(NamedTuple):
    """What answers are judged by, by BOP number: models, surfaces, and names."""

    models: Mapping[int, Model]
    surfaces: Mapping[int, RayMesh]
    names: Mapping[int, str]

    def counted(
        self, shown: Shown, answers: Sequence[Posed], types: Collection[int] | None = None
    ) -> tuple[Counts, list[Told]]:
        """The counts of one photo, and each truth with what stands for it; of some ``types``, or of all."""

        def some(posed: Iterable[Posed]) -> list[Posed]:
            return [one for one in posed if types is None or one.obj_id in types]

        mine = some(asked(answers, shown.truths, shown.hidden, self.models))
        return counted(mine, some(shown.truths), shown.neither, self.models, self.surfaces, shown.camera)

    def total(self, answers: Iterable[tuple[Shown, Sequence[Posed]]], types: Collection[int] | None = None) -> Counts:
        """The counts of many."""
        return sum((self.counted(shown, some, types)[0] for shown, some in answers), Counts())


def measure_of(kb: KnowledgeBase, numbers: Mapping[str, int], models: Path) -> Measure:
    """By the models of a BOP folder, as far as the knowledge base has them and it says how large they are."""
    from plogic.run.bop.models import model_ids

    surfaces = {numbers[k.name]: k.surface.rays for k in kb.types if k.surface is not None and k.name in numbers}
    known = read_models(models, set(surfaces) & set(model_ids(models)))
    return Measure(known, surfaces, {number: name for name, number in numbers.items()})


def row(name: str, counts: Counts, seconds: float) -> dict[str, Any]:
    """One row of counts; ``seconds``: of a photo."""
    return {
        "row": name,
        "there": counts.there,
        "accepted": counts.accepted,
        "right": counts.right,
        "found": counts.found,
        "false": counts.false,
        "precision": round(counts.precision, 3),
        "seconds": round(seconds, 2),
    }


def seconds_of(answers: Sequence[Answer]) -> float:
    """The median of a photo."""
    return median(a.seconds for a in answers)


def wrong(measure: Measure, answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """What is not right: each such object, and what was accepted of types that are not there."""
    rows = []
    for a in answers:
        rows += [
            {"photo": a.shown.name, "type": measure.names[told.obj_id], "error": told.error, "overlap": told.overlap}
            for told in measure.counted(a.shown, a.ours)[1]
            if not told.right
        ]
        there = {some.obj_id for some in a.shown.truths} | a.shown.neither
        rows += [
            {"photo": a.shown.name, "type": f"{measure.names[some.obj_id]}, not there", "error": None, "overlap": None}
            for some in a.ours
            if some.obj_id not in there
        ]
    return rows


def draw(measure: Measure, answers: Sequence[Answer], name: str, folder: Path) -> None:
    """A picture of each photo. Raises SensingError where it cannot be written."""
    import cv2

    from benchmarks.photos.pictures import drawn
    from sensing.files.whole_files import write_whole

    for a in answers:
        told = measure.counted(a.shown, a.ours)[1]
        shown = drawn(a.shown, a.ours, told, measure.surfaces, measure.names)
        file = folder / f"{name}_{a.shown.name.replace('/', '_')}.png"
        write_whole(file, bytes(cv2.imencode(".png", shown)[1].tobytes()))
