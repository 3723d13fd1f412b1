"""What the fit of pixels is worth: the best poses of each type in real and simulated photos, of types there and absent.

``python benchmarks/pixel_odds.py KB DATASET [KB DATASET]``: the types of KB are the models of DATASET, in BOP's layout,
by number or by name; the simulated photos are of tables with things of these types (``--simulated``, so many). Prints a
line for each pose that was refined; then the weights of logistic regressions on what a fit tells: of "it is there" for
what shows print (``sensing.pixels.energy.ODDS``), where neither right nor absent are types that are there without a
pose, and what looks like another type that is there, where that one is, for which of the two it is, their own odds
tell; of "its outline is found" for what is plain (``PLAIN``), where a wrong pose of a type that is there is one of
none. Then, by the weights of the other photos alone: what each photo's poses have; and of the best pose of each type in
each photo how many are accepted where nine of ten of all photos' are found, and of these how many are found, and right.
And how many poses of absent types pass ``PROMISING`` before they are refined; and how many objects, and others, are
given up (``sensing.pixels.refine.HOPELESS``).
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.photos.answers import photos_of
from benchmarks.photos.knowledge import numbers_of
from benchmarks.recognition.scenes import EMPTY_EVERY, HARD
from benchmarks.recognition.score import HALF
from benchmarks.tabletop.scene import recognition_scene
from geometry.arrays import Bytes, Floats, Mask
from geometry.camera import Camera
from geometry.frames import transform_points
from plogic.base.jobs import each, processors
from plogic.match.gamma.data import data_of
from plogic.match.learned.learned_models import LearnedIndex
from plogic.match.learned.learned_pixels import FITTED, FITTED_SEEN, PROMISING, SCREENED, by_odds, screened
from plogic.match.learned.learned_poses import proposed
from plogic.match.learned.learned_views import SEEN, maps_for, seen_anywhere
from plogic.run.bop.dataset import open_dataset
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect
from sensing.pixels.drawn import Paint
from sensing.pixels.energy import ODDS, PLAIN, Fit, printed
from sensing.pixels.photo import Photo
from sensing.pixels.refine import refined

DEVELOPED, APART = 5000, 1000
"""First seed of simulated photos, and how far the next KB's are from it: those of ``plogic bench recognition`` are
below."""
RIGHT = 0.12
"""Diameters of ADD up to which a pose is right here."""
EVENED = 2e-4
"""Weight of the squares of the weights: of 2e-3, 5e-4, 2e-4 the one with the least log loss, left one photo out."""
OVER, FOUND = 0.5, 0.7
"""Intersection over union of outlines from which one object looks like another at its place, and is found there."""
PRECISION, EXACT = 0.9, 0.1
"""Share found of what is accepted; diameters of ADD up to which what is found is right."""
SCALES = (1.0, 5.0, 3.0, 10.0, 10.0), (1.0, 4.0, 3.5, 9.0, 3.0, 3.5, 1.5)
"""Of what ``ODDS`` and ``PLAIN`` are weights of, about one over its standard deviation."""


class Row(NamedTuple):
    """``there``: 1 right, 0 absent, NaN neither; ``found``: 1 its outline is, 0 is not, NaN neither.

    ``off``: ADD, diameters, NaN where it is absent; ``hopeless``: it was given up; ``line``: all of it in words.
    """

    photo: str
    type: str
    there: float
    found: float
    off: float
    coarse: float
    fit: Fit
    hopeless: bool
    line: str


class Seen(NamedTuple):
    """A photo: the true poses (4, 4) of types that are there, and the types that are there without one."""

    name: str
    image: Bytes
    camera: Camera
    posed: dict[str, list[Floats]]
    unposed: frozenset[str]


def real(dataset: Path, names: dict[int, str]) -> Iterator[Seen]:
    """The photos of a BOP dataset."""
    for shown in photos_of(open_dataset(dataset)):
        posed: dict[str, list[Floats]] = {}
        for truth in shown.truths:
            posed.setdefault(names[truth.obj_id], []).append(truth.camera_from_object)
        there = frozenset(names[number] for number in shown.neither)
        yield Seen(f"{dataset.name} {shown.name}", shown.image, shown.camera, posed, there)


def simulated(paints: dict[str, Paint], name: str, first: int, count: int) -> Iterator[Seen]:
    """Photos of tables, seeds from ``first`` on, every sixth without any of the types.

    What is half hidden counts as there without a pose.
    """
    shapes = [(name, paint.mesh) for name, paint in paints.items()]
    for i in range(count):
        empty = i % EMPTY_EVERY == EMPTY_EVERY - 1
        scene = recognition_scene(shapes, first + i, empty=empty, hard=HARD[(i + i // EMPTY_EVERY) % len(HARD)])
        posed: dict[str, list[Floats]] = {}
        hidden = set()
        for body, pose, fraction in zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True):
            if body.label is not None and fraction >= HALF:
                posed.setdefault(body.label, []).append(pose)
            elif body.label is not None:
                hidden.add(body.label)
        camera = replace(scene.camera, world_from_camera=None)
        yield Seen(f"{name}-simulated {i}", scene.photograph().image, camera, posed, frozenset(hidden))


def rows_of(perceiver: Perceiver, shown: Seen) -> Iterator[Row]:
    """The refined poses of all types in a photo."""
    photo, kb = Photo(shown.image, shown.camera), perceiver.kb
    gamma = detect(shown.image, shown.camera, kb.sought, kb.words).in_order()
    data = data_of(gamma.appearances, shown.camera, perceiver.width, photo)
    paints = paints_of(perceiver)
    true = {name: [_mask(paints[name], pose, shown.camera) for pose in poses] for name, poses in shown.posed.items()}
    indices = [some for some in perceiver.models.values() if isinstance(some, LearnedIndex)]
    maps = maps_for(indices, data, 1)
    for name, paint in paints.items():
        index = perceiver.models[name]
        assert isinstance(index, LearnedIndex)  # noqa: S101 - it has paint
        by_keypoints = screened(index, *proposed(index, data, kb, thin=False), data, (), SCREENED)[:FITTED]
        by_views = by_odds(photo, paint, seen_anywhere(index, maps, data))[:FITTED_SEEN]
        for score, pose in [row[:2] for row in by_keypoints] + by_views:
            found = refined(photo, paint, pose)
            if found is None:
                continue
            off = min((_off(index, paint, found.pose, posed) for posed in shown.posed.get(name, ())), default=np.nan)
            mask = _mask(paint, found.pose, shown.camera)
            own = max((_over(mask, other) for other in true.get(name, ())), default=0.0)
            alike = any(_over(mask, other) >= OVER for masks in true.values() for other in masks)
            neither = name in shown.posed or name in shown.unposed or alike
            there = 1.0 if off < RIGHT else np.nan if neither else 0.0
            outlined = 1.0 if own >= FOUND else np.nan if own >= OVER or name in shown.unposed else 0.0
            said = "right" if there == 1.0 else "absent" if there == 0.0 else "neither"
            fit = found.fit
            line = f"{shown.name} {name} {said} ADD {off:.3f} over {own:.2f} coarse {score:.1f} odds {fit.odds:.1f}"
            line = " ".join([line, *(f"{value:.2f}" for value in fit)])
            yield Row(shown.name, name, there, outlined, off, score, fit, found.hopeless, line)


def paints_of(perceiver: Perceiver) -> dict[str, Paint]:
    """The types that have a texture, by name."""
    learned = {name: some for name, some in perceiver.models.items() if isinstance(some, LearnedIndex)}
    return {name: some.paint for name, some in learned.items() if some.paint is not None}


def _mask(paint: Paint, pose: Floats, camera: Camera) -> Mask:
    return paint.drawn(pose, camera.K, (camera.width, camera.height)).mask


def _over(one: Mask, other: Mask) -> float:
    return float((one & other).sum() / max(1, (one | other).sum()))


def _off(index: LearnedIndex, paint: Paint, pose: Floats, true: Floats) -> float:
    """ADD up to symmetry, diameters."""
    places = paint.mesh.vertices
    here = transform_points(pose, places)
    turned = (transform_points(true @ motion, places) for motion in index.object_type.symmetries)
    return float(min(np.linalg.norm(here - there, axis=1).mean() for there in turned)) / paint.diameter


def learned(rows: list[Row]) -> tuple[Floats, Floats]:
    """(5,) the weights of what shows print, and (7,) those of what is plain."""
    some = [row for row in rows if not np.isnan(row.there)]
    outlined = [row for row in rows if not np.isnan(row.found)]
    share = np.array([printed(row.fit) for row in some])
    plainly = np.array([1.0 - printed(row.fit) for row in outlined])
    return (
        logistic([row.fit.told for row in some], [row.there for row in some], share, SCALES[0]),
        logistic([row.fit.told_plainly for row in outlined], [row.found for row in outlined], plainly, SCALES[1]),
    )


def logistic(
    told: Sequence[tuple[float, ...]], there: Sequence[float], share: Floats, scales: Sequence[float]
) -> Floats:
    """(K,) weights, the classes balanced, none but the first below 0; ``share`` (N,): how much each counts."""
    from scipy.optimize import minimize

    scale = np.array(scales)
    X, y = np.array(told) * scale, np.array(there)
    if not (share @ y and share @ (1.0 - y)):
        return np.full(len(scale), np.nan)
    weight = share * np.where(y > 0, 0.5 / (share @ y), 0.5 / (share @ (1.0 - y)))

    def loss(w: Floats) -> float:
        z = X @ w
        return float((weight * (np.logaddexp(0.0, z) - y * z)).sum() + EVENED * (w[1:] ** 2).sum())

    bounds = [(None, None)] + [(0.0, None)] * (len(scale) - 1)
    return np.asarray(minimize(loss, np.zeros(len(scale)), bounds=bounds).x * scale)


def odds_by(weights: tuple[Floats, Floats], fit: Fit) -> float:
    """A fit's odds by other weights; what has none of its kind counts for nothing."""
    both = float(np.dot(weights[0], fit.told)), float(np.dot(weights[1], fit.told_plainly))
    return float(np.nan_to_num(printed(fit) * both[0]) + np.nan_to_num((1.0 - printed(fit)) * both[1]))


def accepted(rows: list[Row], odds: list[float]) -> tuple[int, int, int, float]:
    """The best pose of each type in each photo: how many have the least odds with ``PRECISION``.

    And of these those that are found, and right; and the least odds.
    """
    best: dict[tuple[str, str], int] = {}
    for k, row in enumerate(rows):
        key = row.photo, row.type
        if key not in best or odds[k] > odds[best[key]]:
            best[key] = k
    order = sorted(best.values(), key=lambda k: -odds[k])
    found = np.array([rows[k].found == 1.0 for k in order])
    right = found & np.array([rows[k].off < EXACT for k in order])
    enough = np.flatnonzero(np.cumsum(found) >= PRECISION * np.arange(1, len(found) + 1))
    n = int(enough[-1]) + 1 if len(enough) else 0
    return n, int(found[:n].sum()), int(right[:n].sum()), odds[order[n - 1]] if n else np.inf


def main(pairs: Sequence[tuple[str, Path]], count: int) -> None:
    """Print it all."""
    rows: list[Row] = []
    for k, (kb_folder, dataset) in enumerate(pairs):
        kb = kb_of(kb_folder)
        perceiver = Perceiver(kb)
        paints = paints_of(perceiver)
        numbers = numbers_of(kb, dataset / "models")
        made = simulated(paints, dataset.name, DEVELOPED + APART * k, count)
        photos = [*real(dataset, {numbers[name]: name for name in perceiver.models}), *made]
        for some in each(lambda shown: list(rows_of(perceiver, shown)), photos, processors()):  # noqa: B023 - used here
            print(*(row.line for row in some), sep="\n", flush=True)  # noqa: T201 - a script
            rows += some
    told(rows)


def told(rows: list[Row]) -> None:
    """Print what the rows tell."""
    right, absent = ([row for row in rows if row.there == value] for value in (1.0, 0.0))
    passed = sum(row.coarse >= PROMISING for row in absent)
    print(f"{len(right)} right, {len(absent)} of absent types, {passed} of these coarsely above {PROMISING:g}")  # noqa: T201
    good = [row for row in rows if 1.0 in (row.there, row.found)]
    objects = {(row.photo, row.type) for row in good}
    lost = objects - {(row.photo, row.type) for row in good if not row.hopeless}
    others = [row.hopeless for row in rows if 1.0 not in (row.there, row.found)]
    print(f"given up: {len(lost)} of {len(objects)} objects, {sum(others)} of {len(others)} other poses")  # noqa: T201
    for name, weights, used in zip(("print", "plain"), learned(rows), (ODDS, PLAIN), strict=True):
        print(f"{name}: weights", np.round(weights, 1), "in use", used)  # noqa: T201
    by_photo = {
        photo: learned([row for row in rows if row.photo != photo]) for photo in sorted({r.photo for r in rows})
    }
    odds = [odds_by(by_photo[row.photo], row.fit) for row in rows]
    print("left one photo out:")  # noqa: T201
    for kind in sorted({row.photo.split()[0] for row in rows}):
        mine = [k for k, row in enumerate(rows) if row.photo.split()[0] == kind]
        there, wrong = (np.array([odds[k] for k in mine if rows[k].there == value] or [np.nan]) for value in (1.0, 0.0))
        loss = (np.logaddexp(0.0, -there).mean() + np.logaddexp(0.0, wrong).mean()) / 2.0
        above, below = (wrong > SEEN).sum(), (there <= SEEN).sum()
        print(  # noqa: T201
            f"{kind}: log loss {loss:.4f}; right from {there.min():.1f}, {below} of {len(there)} not above {SEEN:g};",
            f"absent up to {wrong.max():.1f}, {above} of {len(wrong)} above {SEEN:g}",
        )
        for said, some in (("learned", [odds[k] for k in mine]), ("in use", [rows[k].fit.odds for k in mine])):
            n, found, exact, least = accepted([rows[k] for k in mine], some)
            print(f"{kind}, {said}: {n} accepted from {least:.1f} on: {found} found, {exact} right")  # noqa: T201


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folders", nargs="+", metavar="KB DATASET")
    parser.add_argument("--simulated", type=int, default=36, metavar="N")
    asked = parser.parse_args()
    if len(asked.folders) % 2:
        parser.error("a folder of a KB goes with one of a dataset")
    main(
        [(kb, Path(dataset)) for kb, dataset in zip(asked.folders[::2], asked.folders[1::2], strict=True)],
        asked.simulated,
    )
