"""How exactly things stand on planes, how often what is not there stands there too, and how well planes are found.

``python benchmarks/planes.py KB DATASET``: the types of KB are those of DATASET, real photos in BOP's layout, by number
or by name; ``--scenes N``: of its models so many rendered scenes, those of ``plogic bench support`` but for their
seeds, instead of its photos. The true plane of a photo is the one that the true poses speak for
(``plogic.cycle.planes``). Prints by how much true poses that stand on it are off it, and by how many nats they speak
for their planes (``geometry.bodies.standing.NOISES``); which share of the proposals of what is not there, one of a
place, stand on it all the same, or are level above it (``plogic.cycle.planes``, ``FREE`` and ``PUT``), and of the
others; and how far the plane is on which what was accepted stands. Every plain type is looked for on the true
plane as well: printed is what the pixels of the best of each tell, and what has to be added to that so that it is the
logarithm of a likelihood ratio: next to nothing.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.photos.answers import Shown, photos_of
from benchmarks.photos.knowledge import numbers_of
from benchmarks.photos.planes import true_bodies, true_plane
from benchmarks.photos.score import OUTLINED, Posed, overlap_of
from benchmarks.shared.arguments import of_kb_and_dataset
from benchmarks.support.bench import scenes_with
from geometry.arrays import Floats
from geometry.bodies.resting import Plane
from geometry.bodies.standing import Known, joined, log_level, log_ratios, off, ways
from plogic.base.clock import Stopwatch
from plogic.base.jobs import processors
from plogic.cycle.delta import Options
from plogic.cycle.planes import Bodies, Setting, abduced, bodies_of, standing_on, supported, with_noise
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import data_of
from plogic.match.judged.rivals import same_place
from plogic.match.learned.learned_models import LearnedIndex
from plogic.match.learned.learned_poses import resting
from plogic.match.learned.learned_views import maps_for, seen_on
from plogic.run.bop.dataset import open_dataset
from plogic.run.perceive import Perceiver
from plogic.run.sources import detected, kb_of
from sensing.detectors.detector import detect
from sensing.pixels.photo import Photo

EXACT = 0.003, 0.001
"""Radians and metres: the noise of true poses."""
BESIDE = 0.3
"""Overlap with an object of its type beyond which a pose that is not found is a wrong pose of what is there."""
DEVELOPED = 60_000
"""First seed of rendered scenes: those of the benchmark are from 40000 on."""


class Looked(NamedTuple):
    """Of one photo: what true poses are off their plane, rows of tilt (rad) and share of the distance.

    ``evidence``: by how many nats they speak for it. ``stand``: of proposals, by whether each was looked for on a plane
    and is found: how much likelier its pose is if it stands on the true plane, and if level above it; ``error``: of
    the plane found, rad and a share of its height, None where there is none. ``narrow``: what pixels tell of the best
    of each plain type that was looked for on the true plane, and whether it is found.
    """

    truths: Floats
    evidence: float
    stand: dict[tuple[bool, bool], list[tuple[float, float]]]
    error: tuple[float, float] | None
    narrow: list[tuple[float, bool]]


def off_plane(bodies: Bodies, plane: Plane, rests: float) -> Floats:
    """(N, 2) of those that stand on a plane: the tilt, rad, and the height above it, a share of the distance."""
    rows, stands = [], bodies.stands
    ratios = log_ratios(stands, plane)
    tilted, above = off(stands, plane)
    for body in np.flatnonzero(standing_on(bodies, plane, rests) > 0.5):
        way = max(np.flatnonzero(stands.body == body), key=lambda k: ratios[k])
        rows.append((np.linalg.norm(tilted[way]), above[way] / np.linalg.norm(stands.foot[way])))
    return np.array(rows).reshape(-1, 2)


def likelier_on(bodies: Bodies, plane: Plane) -> Floats:
    """(2, B) how much likelier each pose is of a body that stands on a plane, and of one that is level above it."""
    stands, many = bodies.stands, len(bodies.kind)
    logs = log_ratios(stands, plane), log_level(stands, plane)
    ways_to = [stands.chance * np.exp(np.minimum(one, 50.0)) for one in logs]
    return np.array([np.bincount(stands.body, row, minlength=many) for row in ways_to])


def shares_of(likelier: list[tuple[float, float]], rounds: int = 200) -> Floats:
    """(2,) the shares of those that stand, and that are level, under which such poses are the likeliest (EM)."""
    told, shares = np.array([(1.0, *row) for row in likelier]), np.full(3, 1.0 / 3.0)
    for _ in range(rounds):
        whose = told * shares
        shares = (whose / whose.sum(axis=1, keepdims=True)).mean(axis=0)
    return np.asarray(shares[1:])


def exact_bodies(truths: list[Hypothesis], setting: Setting) -> Bodies:
    """True poses, which are known to ``EXACT``, off what they stand on."""
    tilt, spread = EXACT[0], EXACT[1] ** 2 * np.eye(3)
    models = [setting.models[one.type] for one in truths]
    rows = enumerate(zip(truths, models, strict=True))
    stands = joined([ways(k, m.resting, one.camera_from_object, m.centre, tilt, spread) for k, (one, m) in rows])
    return with_noise(bodies_of(truths, [], setting)._replace(stands=stands))


def looked(perceiver: Perceiver, shown: Shown, numbers: dict[str, int]) -> Looked | None:
    """One photo; None where its truth stands on no plane."""
    kb, clock = replace(perceiver.kb, maybe=True), Stopwatch()
    setting, rests = Setting(perceiver.models, shown.camera, kb), kb.rests or 0.0
    names = {number: name for name, number in numbers.items()}
    known = [(names[truth.obj_id], truth) for truth in shown.truths if truth.obj_id in names]
    plane = true_plane(shown, names, setting.models, kb)
    if plane is None:
        return None
    truths = true_bodies(shown, names, setting.models)
    bodies = bodies_of(truths, [], setting)
    gamma = detected(shown.image, shown.camera, kb, clock)
    cycle = perceiver.cycle(gamma, Options(reading="posterior"), clock, image=shown.image)[1]
    neither = {names.get(number) for number in shown.neither}
    every = (*cycle.accepted, *cycle.considered, *cycle.rejected)
    some = [h for h in every if h.pixels is not None and h.type not in neither]
    proposals = with_noise(bodies_of(some, [], setting))
    likelier = likelier_on(proposals, plane)
    told = {(put, found): list[tuple[float, float]]() for put in (False, True) for found in (False, True)}
    for k, posed in enumerate(some):
        most = overlap_with(posed, known, perceiver, shown)
        kind, pose = posed.object_type, posed.camera_from_object
        before = (one.camera_from_object for one in some[:k] if one.type == posed.type)
        if BESIDE < most < OUTLINED or any(same_place(kind, pose, old) for old in before):
            continue
        told[posed.released is not None, most >= OUTLINED].append((float(likelier[0, k]), float(likelier[1, k])))
    planes = abduced(cycle.accepted, [], setting, rests)[1].planes
    found = planes[0].known.plane if planes else None
    error = None if found is None else (found.turned(plane), abs(found.offset / plane.offset - 1.0))
    on_it = abduced(truths, [], setting, rests)[1].planes[0].known
    narrow = [
        (best.pixels or 0.0, overlap_with(best, known, perceiver, shown) >= OUTLINED)
        for best in looked_for(perceiver, shown, on_it)
        if best.type not in neither
    ]
    of_planes = supported(exact_bodies(truths, setting), rests)
    evidence = float(np.logaddexp.reduce(of_planes.prior + of_planes.told.sum(axis=1)))
    return Looked(off_plane(bodies, plane, rests), evidence, told, error, narrow)


def looked_for(perceiver: Perceiver, shown: Shown, known: Known) -> Iterator[Hypothesis]:
    """The best pose of each plain type on a plane by its pixels."""
    kb, nobody = perceiver.kb, np.zeros((0, 4))
    gamma = detect(shown.image, shown.camera, kb.sought, kb.words).in_order()
    data = data_of(gamma.appearances, shown.camera, perceiver.width, Photo(shown.image, shown.camera))
    indices = [some for some in perceiver.models.values() if isinstance(some, LearnedIndex) and some.plain]
    maps = maps_for(indices, data, 1)
    for index in indices:
        found = resting(index, known, data, kb, nobody, seen=seen_on(index, maps, data, [known])[0])
        some = [(h.pixels, h) for _, h in found if h.pixels is not None]
        if some:
            yield max(some, key=lambda row: row[0])[1]


def narrow_of(rows: list[tuple[float, bool]]) -> float:
    """What is to be added to what pixels tell: the least log loss, beside the share that is found."""
    from scipy.optimize import minimize_scalar

    told, there = np.array([value for value, _ in rows]), np.array([found for _, found in rows])
    prior = np.log(there.sum() / (~there).sum())
    return float(
        minimize_scalar(lambda more: np.logaddexp(0.0, np.where(there, -1.0, 1.0) * (told + prior + more)).sum()).x
    )


def overlap_with(posed: Hypothesis, known: list[tuple[str, Posed]], perceiver: Perceiver, shown: Shown) -> float:
    """The most by which the outline of a pose is that of an object of its type that is there."""
    surface = perceiver.models[posed.type].object_type.surface
    if surface is None:
        return 0.0
    truths = [truth for name, truth in known if name == posed.type]
    answers = [Posed(truth.obj_id, posed.camera_from_object) for truth in truths]
    pairs = zip(answers, truths, strict=True)
    return max((overlap_of(answer, truth, surface.rays, shown.camera) for answer, truth in pairs), default=0.0)


def main(kb_folder: str, dataset: Path, scenes: int | None) -> None:
    """Print it all."""
    perceiver = Perceiver(replace(kb_of(kb_folder), maybe=True), processes=processors())
    numbers = numbers_of(perceiver.kb, dataset / "models")
    seeds = range(DEVELOPED, DEVELOPED + (scenes or 0))
    rendered = (stood.shown for stood in scenes_with(perceiver.kb, numbers, dataset, seeds))
    photos = rendered if scenes else photos_of(open_dataset(dataset))
    rows = [one for shown in photos if (one := looked(perceiver, shown, numbers)) is not None]
    truths = np.concatenate([one.truths for one in rows])
    tilt, level = np.sqrt(np.mean(truths[:, 0] ** 2) / 2.0), np.sqrt(np.mean(truths[:, 1] ** 2))
    print(f"{len(truths)} true poses: off their plane by {tilt:.3f} rad about each axis, {level:.4f} of the distance")  # noqa: T201 - a script
    print(f"they speak for their planes by {sum(one.evidence for one in rows):.1f} nats")  # noqa: T201
    for put, found in rows[0].stand:
        told = [s for one in rows for s in one.stand[put, found]]
        on, level = shares_of(told) if told else (0.0, 0.0)
        name = f"{'put on a plane and released' if put else 'free'}, {'found' if found else 'of what is not there'}"
        print(f"{len(told)} proposals, {name}: {on:.2f} stand on the true plane, {level:.2f} are level above it")  # noqa: T201
    narrow = [row for one in rows for row in one.narrow]
    for name, wanted in (("wrong", False), ("found", True)):
        some = [told for told, found in narrow if found is wanted]
        by_tenths = " ".join(f"{value:.1f}" for value in np.quantile(some, (0.1, 0.25, 0.5, 0.75, 0.9)))
        print(f"looked for on the true plane and {name}: {len(some)}, pixels tell {by_tenths} (tenth to nine tenths)")  # noqa: T201
    print(f"to add to what pixels tell there: {narrow_of(narrow):.2f}")  # noqa: T201
    for one in rows:
        said = (
            "none" if one.error is None else f"{np.degrees(one.error[0]):.1f} degrees, {one.error[1]:.3f} of its height"
        )
        print(f"plane found: off by {said}")  # noqa: T201


if __name__ == "__main__":
    parser = of_kb_and_dataset(__doc__)
    parser.add_argument("--scenes", type=int, metavar="N")
    asked = parser.parse_args()
    main(asked.kb, asked.dataset, asked.scenes)
