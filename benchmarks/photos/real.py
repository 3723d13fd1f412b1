"""Real photos with posed objects, beside SIFT's ratio test with RANSAC on the same learned keypoints.

The peer has the setting that is best over these very photos.
"""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING, Any

from benchmarks.photos import told
from benchmarks.photos.answers import Looker, photos_of
from benchmarks.photos.knowledge import known, resting
from benchmarks.photos.planes import Side, of_support, true_plane
from benchmarks.photos.score import Posed
from benchmarks.photos.table import Report, draw, measure_of, row, seconds_of, wrong
from benchmarks.recognition.peer import SEEN, Peer, accepted, settings
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from benchmarks.photos.answers import Shown
    from benchmarks.recognition.peer import Candidates
    from geometry.bodies.resting import Plane
    from plogic.run.bop.dataset import Dataset

RIGHT = {"ycb": 11, "lmo": 22}
FOUND = {"ycb": 11, "lmo": 40}
"""How many the issues on real photos and on support ask for, of 12 and of 89."""
FIRST = {"lmo": 35}
"""Of how many the outline is to be that of the candidate of their type that pixels speak for most."""
CALIBRATED = 0.08


def of_dataset(
    dataset: Dataset, name: str, kept: Path | None, seed: int, say: Callable[[str], None], pictures: Path | None
) -> Report:
    """Every photo of a dataset; ``kept``: its learned knowledge base; ``pictures``: their folder."""
    assert dataset.models is not None  # noqa: S101 - it has been opened as a whole dataset with models
    answers, unsupported, peers = [], [], []
    planes: dict[str, Plane | None] = {}
    with known(dataset.models, kept, seed, say) as (kb, numbers):
        measure = measure_of(kb, numbers, dataset.models)
        looker, other = (Looker(resting(kb, maybe=maybe), numbers) for maybe in (True, False))
        peer = Peer({kind.name: kind.learned.keypoints for kind in kb.types if kind.learned is not None}, SEEN[:1])
        for shown in photos_of(dataset):
            answers.append(looker.answer(shown, measure.models))
            unsupported.append(other.answer(shown, measure.models))
            planes[shown.name] = true_plane(shown, measure.names, looker.models, looker.kb)
            peers.append(peer.candidates(shown.image, shown.camera))
            say(answers[-1].said(measure.names))

    def theirs(candidates: Candidates, setting: Any) -> list[Posed]:  # noqa: ANN401 - the peer's
        return [Posed(numbers[f.type], f.camera_from_object) for f in accepted(candidates, setting)]

    shown_all: list[Shown] = [a.shown for a in answers]
    mine = measure.total((a.shown, a.ours) for a in answers)
    without = measure.total((a.shown, a.ours) for a in unsupported)
    first = measure.total((a.shown, a.first) for a in answers)
    tried = [
        measure.total((shown, theirs(p, setting)) for shown, (p, _) in zip(shown_all, peers, strict=True))
        for setting in settings(SEEN[:1])
    ]
    best = max(tried, key=lambda c: c.right - c.false)
    if pictures is not None:
        draw(measure, answers, name, pictures)
    claimed = tuple(f._replace(photo=f"{name} {f.photo}") for a in answers for f in a.told)
    claims = [
        Claim(f"{name}: right, of {mine.there}", ">=", RIGHT[name], mine.right),
        Claim(f"{name}: found", ">=", FOUND[name], mine.found),
        Claim(f"{name}: precision", ">=", 0.9, mine.precision),
        Claim(f"{name}: accepted of types that are not there", "<=", 0, mine.false),
        Claim(f"{name}: seconds a photo, median", "<=", 2.0, seconds_of(answers)),
    ]
    if name in FIRST:
        claims.append(Claim(f"{name}: found by the first of its type", ">=", FIRST[name], first.found))
    rows = [
        row(f"{name}, ours", mine, seconds_of(answers)),
        row(f"{name}, without support", without, seconds_of(unsupported)),
        row(f"{name}, the first of each type", first, seconds_of(answers)),
        row(f"{name}, peer", best, median(spent[SEEN[0]] for _, spent in peers)),
    ]
    told_of_planes, by_support = of_support(name, Side(answers, measure), Side(unsupported, measure), planes)
    more = {
        "not right": [{"of": name, **one} for one in wrong(measure, answers)],
        "planes": [{"of": name, **one} for one in told_of_planes],
        "claimed": told.rows(name, claimed),
    }
    return Report(rows, more, [*claims, *by_support], claimed)


def of_all(reports: Sequence[Report]) -> Report:
    """The claims of documents over all datasets: of one alone they are few."""
    claimed = [f for some in reports for f in some.told]
    more = {"claimed": told.rows("all", claimed)} if len(reports) > 1 else {}
    return Report([], more, told.claims("photos", claimed, CALIBRATED))
