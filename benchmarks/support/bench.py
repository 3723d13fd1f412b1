"""``plogic bench support``: rendered scenes whose planes and stances are known, with support and without, side by side.

The models lie where those of ``plogic bench photos`` do: each set's types are in a knowledge base of their own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from benchmarks.photos import bench as photos
from benchmarks.photos.answers import Looker
from benchmarks.photos.knowledge import known, of_types, resting
from benchmarks.photos.pictures import folder_made
from benchmarks.photos.scenes import PLAIN, PRINTED, as_symmetric
from benchmarks.photos.table import measure_of
from benchmarks.photos.told import NAMED, forecasts
from benchmarks.shared.claims import report
from benchmarks.support import table
from benchmarks.support.pictures import draw
from benchmarks.support.scenes import FIRST, STEP, pictures_of
from benchmarks.support.score import judged
from benchmarks.support.solids import Solid
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from benchmarks.photos.table import Measure
    from benchmarks.support.scenes import Stood
    from benchmarks.support.score import Judged
    from kb.clouds.cloud import KnowledgeBase

COUNT, QUICK_COUNT = 200, 12
SHARES = {"ycb": 3, "lmo": 1}
"""Of four pictures, so many show types of a set; a set that is not there leaves its own to the other."""
APART = 500
"""Seeds from one set's first to the next one's."""


class Asked(NamedTuple):
    """What is asked for: the seed, where KBs are kept and pictures drawn, and who is told of progress."""

    seed: int
    kb: Path | None
    pictures: Path | None
    say: Callable[[str], None]


def run(
    *,
    seed: int,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    pictures: Path | None = None,
    kb: Path | None = None,
    count: int | None = None,
) -> tuple[str, bool]:
    """Run the benchmark, of ``quick`` the first set alone; ``pictures``: the folder of a picture of each scene.

    ``kb``: the folder of the learned knowledge bases, each of its set's name: what is not there is learned into it.
    ``count``: how many scenes.

    Raises:
        InputError: No models are there, or they cannot be learned, or the folder of pictures cannot be made.
    """
    missing: list[str] = []

    def note(text: str) -> None:
        say(text)
        missing.append(text)

    asked = Asked(seed, kb, None if pictures is None else folder_made(pictures), say)
    sides: table.Sides = {side: [] for side in table.SIDES}
    for name, numbers in shared(count or (QUICK_COUNT if quick else COUNT), seed, note, quick=quick).items():
        for side, some in _of_set(name, numbers, asked).items():
            sides[side] += some
    for text in table.missing(sides):
        note(text)
    more = table.more(sides) | ({"missing": [{"missing": text} for text in missing]} if missing else {})
    return report("support", table.rows(sides), table.claims(sides), as_json=as_json, more=more)


def shared(count: int, seed: int, note: Callable[[str], None], *, quick: bool) -> dict[str, range]:
    """The seeds of each set's scenes, ``count`` in all. Raises InputError where no set's models are there."""
    sets = list(SHARES)[:1] if quick else list(SHARES)
    there = [name for name in sets if (photos.FOLDER / name / "models").is_dir()]
    for name in (one for one in sets if one not in there):
        note(f"{photos.FOLDER / name}: has no models: their scenes are left out")
    if not there:
        raise InputError(f"{photos.FOLDER}: there are no models: PLOGIC_PHOTOS may name their folder")
    numbers, left, weight = {}, count, sum(SHARES[name] for name in there)
    for name in there:
        own = round(left * SHARES[name] / weight)
        first = FIRST + STEP * seed + APART * list(SHARES).index(name)
        numbers[name] = range(first, first + own)
        left, weight = left - own, weight - SHARES[name]
    return {name: some for name, some in numbers.items() if some}


def _of_set(name: str, numbers: Sequence[int], asked: Asked) -> dict[str, list[Judged]]:
    """Each side's answers to the scenes of these seeds."""
    models, kept = photos.FOLDER / name / "models", None if asked.kb is None else asked.kb / name
    with known(models, kept, asked.seed, asked.say) as (kb, types):
        whole = measure_of(kb, types, models)
        measure, groups = whole._replace(models=as_symmetric(whole.models)), groups_of(name, whole)
        solids = solids_of(kb, groups, measure.names)
        names = {measure.names[number] for own in groups.values() for number in own}
        found: dict[str, list[Judged]] = {side: [] for side in table.SIDES}
        own = of_types(kb, names)
        lookers = {side: Looker(resting(own, maybe=side == table.WITH), types) for side in table.SIDES}
        for stood in pictures_of(solids, numbers):
            for side, looker in lookers.items():
                found[side].append(_answered(stood, side, looker, measure, groups, asked))
    return found


def _answered(
    stood: Stood, side: str, looker: Looker, measure: Measure, groups: Mapping[str, Sequence[int]], asked: Asked
) -> Judged:
    looked = looker.looked(stood.shown)
    answers = looker.accepted(looked.document)
    if asked.pictures is not None and side == table.WITH:
        draw(stood, tuple(answers.values()), measure, asked.pictures)
    told = judged(stood, looked.document, answers, measure, groups)
    there = [f for f in forecasts(looked.document, looker.numbers, stood.shown, measure.models) if f.claim == NAMED]
    found = sum(thing.row.found for thing in told.things)
    asked.say(f"scene {stood.shown.name}, {side}: {found} of {len(told.things)} found in {looked.seconds:.1f} s")
    return told._replace(seconds=looked.seconds, claimed=(*told.claimed, *there))


def groups_of(name: str, measure: Measure) -> dict[str, tuple[int, ...]]:
    """The types of a set that have models, by BOP number, those with print apart; without are all of another set's.

    Raises InputError where there are none.
    """
    kinds = {table.PRINTED: PRINTED, table.PLAIN: PLAIN} if name == "ycb" else {table.PLAIN: tuple(measure.models)}
    there = {f"{kind}, {name}": tuple(n for n in own if n in measure.models) for kind, own in kinds.items()}
    if not any(there.values()):
        raise InputError(f"{name}: has models of none of the types {', '.join(map(str, (*PRINTED, *PLAIN)))}")
    return {group: own for group, own in there.items() if own}


def scenes_with(kb: KnowledgeBase, numbers: Mapping[str, int], dataset: Path, seeds: Sequence[int]) -> Iterator[Stood]:
    """Scenes of other seeds than the benchmark's with the models of a BOP dataset, by whose ``numbers`` types go."""
    measure = measure_of(kb, numbers, dataset / "models")
    return pictures_of(solids_of(kb, groups_of(dataset.name, measure), measure.names), seeds)


def solids_of(kb: KnowledgeBase, groups: Mapping[str, Sequence[int]], names: Mapping[int, str]) -> list[list[Solid]]:
    """The painted meshes of the types of each group, as the knowledge base renders them; labels are BOP numbers.

    Raises SceneError, ImageError.
    """
    from sensing.simulated.body import read_mesh

    def solid(number: int) -> Solid:
        kind = kb.type(names[number])
        assert kind.mesh_file is not None  # noqa: S101 - it has a model
        return Solid(str(number), read_mesh(kind.mesh_file, kind.mesh_scale))

    return [[solid(number) for number in own] for own in groups.values()]
