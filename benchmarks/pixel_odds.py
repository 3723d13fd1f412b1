"""What the fit of pixels is worth: the best poses of each type in real and simulated photos, of types there and absent.

``python benchmarks/pixel_odds.py KB SCENE``: the types of KB are those of SCENE's dataset, by number or by name; the
simulated photos are of tables with things of these types (``--simulated``, so many). Prints a line for each pose that
was refined; then the weights of a logistic regression of "it is there" on what a fit tells
(``sensing.pixels.energy.ODDS``), what each photo's poses have by the others alone, and how many poses of absent types
pass ``PROMISING`` before they are refined. Neither right nor absent are types that are there without a pose, and what
looks like another type that is there, where that one is: which of the two it is, their own odds tell.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.recognition.scenes import EMPTY_EVERY, HARD
from benchmarks.recognition.score import HALF
from benchmarks.tabletop.scene import recognition_scene
from geometry.arrays import Bytes, Floats, Mask
from geometry.camera import Camera
from geometry.files.camera_files import read_camera
from geometry.frames import from_rotation_translation, transform_points
from plogic.base.jobs import each, processors
from plogic.match.gamma.data import data_of
from plogic.match.judged.rivals import distinct_poses
from plogic.match.judged.type_models import SURE
from plogic.match.learned.learned_models import LearnedIndex
from plogic.match.learned.learned_pixels import FITTED, PROMISING, SCREENED
from plogic.match.learned.learned_poses import proposed
from plogic.run.bop.models import ids_of, model_names
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect
from sensing.files.images import read_image
from sensing.pixels.crop import crop_of
from sensing.pixels.drawn import Paint
from sensing.pixels.energy import ODDS, fit_of
from sensing.pixels.photo import Photo
from sensing.pixels.refine import COARSE, refined

DEVELOPED = 5000
"""First seed of simulated photos: those of ``plogic bench recognition`` are below."""
RIGHT = 0.12
"""Diameters of ADD up to which a pose is right here."""
EVENED = 2e-4
"""Weight of the squares of the weights: of 2e-3, 5e-4, 2e-4 the one with the least log loss, left one photo out."""
OVER = 0.5
"""Intersection over union of outlines from which one object looks like another at its place."""


class Row(NamedTuple):
    """``there``: 1 right, 0 absent, NaN neither; ``told``: what the weights are of; ``line``: all of it in words."""

    photo: str
    there: float
    coarse: float
    told: tuple[float, ...]
    line: str


class Shown(NamedTuple):
    """A photo: the true poses (4, 4) of types that are there, and the types that are there without one."""

    name: str
    image: Bytes
    camera: Camera
    posed: dict[str, list[Floats]]
    unposed: frozenset[str]


def real(scene: Path, names: dict[int, str]) -> Iterator[Shown]:
    """The photos of a BOP scene."""
    truth = json.loads((scene / "scene_gt.json").read_text())
    beside = scene / "present.json"
    unposed = json.loads(beside.read_text()) if beside.exists() else {}
    for key, entries in truth.items():
        posed: dict[str, list[Floats]] = {}
        for entry in entries:
            posed.setdefault(names[entry["obj_id"]], []).append(_pose(entry))
        file = next((scene / "rgb").glob(f"{int(key):06d}.*"))
        camera = read_camera(scene / "scene_camera.json", frame=int(key))
        there = frozenset(names[number] for number in unposed.get(key, []))
        yield Shown(f"real {key}", read_image(file), camera, posed, there)


def simulated(paints: dict[str, Paint], count: int) -> Iterator[Shown]:
    """Photos of tables, every sixth without any of the types; what is half hidden counts as there without a pose."""
    shapes = [(name, paint.mesh) for name, paint in paints.items()]
    for i in range(count):
        empty = i % EMPTY_EVERY == EMPTY_EVERY - 1
        scene = recognition_scene(shapes, DEVELOPED + i, empty=empty, hard=HARD[(i + i // EMPTY_EVERY) % len(HARD)])
        posed: dict[str, list[Floats]] = {}
        hidden = set()
        for body, pose, fraction in zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True):
            if body.label is not None and fraction >= HALF:
                posed.setdefault(body.label, []).append(pose)
            elif body.label is not None:
                hidden.add(body.label)
        camera = replace(scene.camera, world_from_camera=None)
        yield Shown(f"simulated {i}", scene.photograph().image, camera, posed, frozenset(hidden))


def rows_of(perceiver: Perceiver, shown: Shown) -> Iterator[Row]:
    """The refined poses of all types in a photo."""
    photo, kb = Photo(shown.image, shown.camera), perceiver.kb
    gamma = detect(shown.image, shown.camera, kb.sought, kb.words).in_order()
    data = data_of(gamma.appearances, shown.camera, perceiver.width, photo)
    paints = paints_of(perceiver)
    true = {name: [_mask(paints[name], pose, shown.camera) for pose in poses] for name, poses in shown.posed.items()}
    for name, paint in paints.items():
        index = perceiver.models[name]
        assert isinstance(index, LearnedIndex)  # noqa: S101 - it has paint
        poses, _ = proposed(index, data, kb, thin=False)
        some = distinct_poses(index.object_type, poses, SCREENED)
        crops = [(crop_of(photo, paint, pose, COARSE), pose) for pose in some]
        coarse = [(fit_of(crop, paint, pose).score, pose) for crop, pose in crops if crop is not None]
        for score, pose in sorted(coarse, key=lambda pair: -pair[0])[:FITTED]:
            found = refined(photo, paint, pose)
            if found is None:
                continue
            off = min((_off(index, paint, found[0], posed) for posed in shown.posed.get(name, ())), default=np.nan)
            mask = _mask(paint, found[0], shown.camera)
            alike = any(_over(mask, other) >= OVER for masks in true.values() for other in masks)
            neither = name in shown.posed or name in shown.unposed or alike
            there = 1.0 if off < RIGHT else np.nan if neither else 0.0
            said = "right" if there == 1.0 else "absent" if there == 0.0 else "neither"
            fit = found[1]
            line = f"{shown.name} {name} {said} ADD {off:.3f} coarse {score:.1f} odds {fit.odds:.1f}"
            yield Row(shown.name, there, score, fit.told, " ".join([line, *(f"{value:.2f}" for value in fit)]))


def paints_of(perceiver: Perceiver) -> dict[str, Paint]:
    """The types that have a texture, by name."""
    learned = {name: some for name, some in perceiver.models.items() if isinstance(some, LearnedIndex)}
    return {name: some.paint for name, some in learned.items() if some.paint is not None}


def _mask(paint: Paint, pose: Floats, camera: Camera) -> Mask:
    return paint.drawn(pose, camera.K, (camera.width, camera.height)).mask


def _over(one: Mask, other: Mask) -> float:
    return float((one & other).sum() / max(1, (one | other).sum()))


def _pose(entry: dict[str, list[float]]) -> Floats:
    return from_rotation_translation(np.reshape(entry["cam_R_m2c"], (3, 3)), np.array(entry["cam_t_m2c"]) / 1000.0)


def _off(index: LearnedIndex, paint: Paint, pose: Floats, true: Floats) -> float:
    """ADD up to symmetry, diameters."""
    places = paint.mesh.vertices
    here = transform_points(pose, places)
    turned = (transform_points(true @ motion, places) for motion in index.object_type.symmetries)
    return float(min(np.linalg.norm(here - there, axis=1).mean() for there in turned)) / paint.diameter


def logistic(rows: list[Row]) -> Floats:
    """(5,) weights, the classes balanced."""
    from scipy.optimize import minimize

    scale = np.array([1.0, 5.0, 3.0, 10.0, 10.0])
    X, y = np.array([row.told for row in rows]) * scale, np.array([row.there for row in rows])
    weight = np.where(y > 0, 0.5 / y.sum(), 0.5 / (1.0 - y).sum()) * len(y)

    def loss(w: Floats) -> float:
        z = X @ w
        return float((weight * (np.logaddexp(0.0, z) - y * z)).sum() + EVENED * len(y) * (w[1:] ** 2).sum())

    return np.asarray(minimize(loss, np.zeros(len(scale))).x * scale)


def main(kb_folder: str, scene: Path, count: int) -> None:
    """Print it all."""
    kb = kb_of(kb_folder)
    perceiver = Perceiver(kb)
    paints = paints_of(perceiver)
    numbers = model_names(scene.parent.parent / "models") | ids_of([kind.name for kind in kb.types], {})
    rows: list[Row] = []
    photos = [*real(scene, {numbers[name]: name for name in perceiver.models}), *simulated(paints, count)]
    for some in each(lambda shown: list(rows_of(perceiver, shown)), photos, processors()):
        print(*(row.line for row in some), sep="\n", flush=True)  # noqa: T201 - a script
        rows += some
    told = [row for row in rows if not np.isnan(row.there)]
    absent = [row for row in told if row.there == 0.0]
    passed = sum(row.coarse >= PROMISING for row in absent)
    counts = f"{len(told) - len(absent)} right, {len(absent)} of absent types"
    print(f"{counts}, {passed} of these coarsely above {PROMISING:g}")  # noqa: T201
    print("weights", np.round(logistic(told), 1), "in use", ODDS)  # noqa: T201
    odds: dict[tuple[str, float], list[float]] = {}
    for photo in sorted({row.photo for row in told}):
        weights = logistic([row for row in told if row.photo != photo])
        for row in (row for row in told if row.photo == photo):
            odds.setdefault((photo.split()[0], row.there), []).append(float(np.dot(weights, row.told)))
    print("left one photo out:")  # noqa: T201
    for kind in ("real", "simulated"):
        right, wrong = np.array(odds.get((kind, 1.0), [np.nan])), np.array(odds.get((kind, 0.0), [np.nan]))
        loss = (np.logaddexp(0.0, -right).mean() + np.logaddexp(0.0, wrong).mean()) / 2.0
        above, below = (wrong > SURE).sum(), (right <= SURE).sum()
        print(  # noqa: T201
            f"{kind}: log loss {loss:.4f}; right from {right.min():.1f}, {below} of {len(right)} not above {SURE:g};",
            f"absent up to {wrong.max():.1f}, {above} of {len(wrong)} above {SURE:g}",
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("kb", metavar="KB")
    parser.add_argument("scene", type=Path, metavar="SCENE")
    parser.add_argument("--simulated", type=int, default=36, metavar="N")
    asked = parser.parse_args()
    main(asked.kb, asked.scene, asked.simulated)
