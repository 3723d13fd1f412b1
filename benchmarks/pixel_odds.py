"""What the fit of pixels is worth: of a BOP scene's photos, the best poses of each type, those there and those absent.

``python benchmarks/pixel_odds.py KB SCENE``: the types of KB are those of SCENE's dataset, by number or by name. Prints
a line for each pose that was refined; then the weights of a logistic regression of "it is there" on edges, region,
print and correlation (``sensing.pixels.energy.ODDS`` and, below it, the same left-one-photo-out), and how many poses of
absent types pass ``PROMISING`` before they are refined. Types that ``present.json`` names without a pose count as
neither.
"""

import argparse
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.files.camera_files import read_camera
from geometry.frames import from_rotation_translation, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.judged.rivals import distinct_poses
from plogic.match.learned.learned_models import LearnedIndex
from plogic.match.learned.learned_pixels import FITTED, PROMISING, SCREENED
from plogic.match.learned.learned_poses import proposed
from plogic.run.bop.models import ids_of, model_names
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect
from sensing.files.images import read_image
from sensing.pixels.crop import crop_of
from sensing.pixels.energy import ODDS, fit_of
from sensing.pixels.photo import Photo
from sensing.pixels.refine import COARSE, refined

RIGHT = 0.12
"""Diameters of ADD up to which a pose is right here."""
EVENED = 0.02
"""Weight of the squares of the weights, so that few right ones do not make them infinite."""
SHARPER, SHIFT = 2.5, 2.0
"""The logistic's are multiplied and moved so: the classes are balanced in it, and absent types lie within ±2 of its
mean, so that its own slope, which is that of their overlap, understates what lies between the classes."""


class Row(NamedTuple):
    """``there``: 1 right, 0 absent, NaN neither; ``told``: 1, edges, region, print and correlation."""

    photo: int
    there: float
    coarse: float
    told: tuple[float, ...]


def rows_of(perceiver: Perceiver, scene: Path, numbers: dict[str, int]) -> list[Row]:
    """The refined poses of all types in all photos."""
    truth = json.loads((scene / "scene_gt.json").read_text())
    beside = scene / "present.json"
    unposed = json.loads(beside.read_text()) if beside.exists() else {}
    rows = []
    for key in truth:
        file = next((scene / "rgb").glob(f"{int(key):06d}.*"))
        image, camera = read_image(file), read_camera(scene / "scene_camera.json", frame=int(key))
        kb = perceiver.kb
        photo = Photo(image, camera)
        gamma = detect(image, camera, kb.sought, kb.words).in_order()
        data = data_of(gamma.appearances, camera, perceiver.width, photo)
        for name, index in perceiver.models.items():
            if not isinstance(index, LearnedIndex) or index.paint is None:
                continue
            poses, _ = proposed(index, data, kb, thin=False)
            some = distinct_poses(index.object_type, poses, SCREENED)
            crops = [(crop_of(photo, index.paint, pose, COARSE), pose) for pose in some]
            coarse = [(fit_of(crop, index.paint, pose).score, pose) for crop, pose in crops if crop is not None]
            posed = [_pose(entry) for entry in truth[key] if entry["obj_id"] == numbers[name]]
            for score, pose in sorted(coarse, key=lambda pair: -pair[0])[:FITTED]:
                found = refined(photo, index.paint, pose)
                if found is None:
                    continue
                off = min((_off(index, found[0], true) for true in posed), default=np.nan)
                neither = bool(posed) or numbers[name] in unposed.get(key, [])
                there = 1.0 if off < RIGHT else np.nan if neither else 0.0
                fit = found[1]
                rows.append(Row(int(key), there, score, (1.0, fit.edges, fit.region, fit.print_, fit.correlation)))
                said = "right" if there == 1.0 else "absent" if there == 0.0 else "neither"
                print(f"{key} {name} {said} ADD {off:.3f} coarse {score:.1f} odds {fit.odds:.1f}", *np.round(fit, 2))  # noqa: T201 - a script
    return rows


def _pose(entry: dict[str, list[float]]) -> Floats:
    return from_rotation_translation(np.reshape(entry["cam_R_m2c"], (3, 3)), np.array(entry["cam_t_m2c"]) / 1000.0)


def _off(index: LearnedIndex, pose: Floats, true: Floats) -> float:
    assert index.paint is not None  # noqa: S101 - the caller looked
    places = index.paint.mesh.vertices
    apart = transform_points(pose, places) - transform_points(true, places)
    return float(np.linalg.norm(apart, axis=1).mean()) / index.paint.diameter


def logistic(rows: list[Row]) -> Floats:
    """(5,) weights, the classes balanced."""
    from scipy.optimize import minimize

    scale = np.array([1.0, 5.0, 3.0, 27.0, 10.0])
    X, y = np.array([row.told for row in rows]) * scale, np.array([row.there for row in rows])
    weight = np.where(y > 0, 0.5 / y.sum(), 0.5 / (1.0 - y).sum()) * len(y)

    def loss(w: Floats) -> float:
        z = X @ w
        return float((weight * (np.logaddexp(0.0, z) - y * z)).sum() + EVENED * len(y) * (w[1:] ** 2).sum())

    found = minimize(loss, np.zeros(5)).x * scale * SHARPER
    found[0] += SHARPER * SHIFT
    return np.asarray(found)


def main(kb_folder: str, scene: Path) -> None:
    """Print it all."""
    kb = kb_of(kb_folder)
    perceiver = Perceiver(kb)
    numbers = model_names(scene.parent.parent / "models") | ids_of([kind.name for kind in kb.types], {})
    rows = rows_of(perceiver, scene, numbers)
    told = [row for row in rows if not np.isnan(row.there)]
    absent = [row for row in told if row.there == 0.0]
    passed = sum(row.coarse >= PROMISING for row in absent)
    counts = f"{len(told) - len(absent)} right, {len(absent)} of absent types"
    print(f"{counts}, {passed} of these coarsely above {PROMISING:g}")  # noqa: T201 - a script
    print("weights", np.round(logistic(told), 1), "in use", ODDS)  # noqa: T201
    for photo in sorted({row.photo for row in told}):
        weights = logistic([row for row in told if row.photo != photo])
        odds = [(row.there, float(np.dot(weights, row.told))) for row in told if row.photo == photo]
        right, wrong = ([value for there, value in odds if there == kind] for kind in (1.0, 0.0))
        print(f"photo {photo} left out: right from {min(right, default=np.nan):.1f}, absent up to {max(wrong):.1f}")  # noqa: T201 - a script


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("kb", metavar="KB")
    parser.add_argument("scene", type=Path, metavar="SCENE")
    asked = parser.parse_args()
    main(asked.kb, asked.scene)
