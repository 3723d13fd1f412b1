"""How surely poses are right: ``sensing.pixels.sureness`` calibrated on simulated photos, checked on real ones.

``python benchmarks/pose_odds.py KB DATASET``: the types of KB are the models of DATASET, by number or by name. Objects
of the types are photographed by the simulated camera, one at a time; poses beside the true ones are moved to where they
fit best, and are right or wrong (``RADIUS``). Prints for several ``INDEPENDENT`` the log loss and the expected
calibration error of P(right) on them, then the same of poses beside the posed objects of DATASET, with a 95 % interval
(photos and objects drawn again). Last, ``pose_probability`` of what is accepted in DATASET's photos, of posed types.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.photos.answers import photos_of
from benchmarks.photos.knowledge import numbers_of
from benchmarks.shared.arguments import of_kb_and_dataset
from geometry.arrays import Floats
from geometry.camera import Camera
from geometry.frames import from_rotation_translation, transform_points, turn_about
from kb.clouds.cloud import ObjectType
from plogic.cycle.delta import Options
from plogic.match.learned.learned_models import LearnedIndex
from plogic.run.bop.dataset import open_dataset
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect
from sensing.pixels.drawn import Paint
from sensing.pixels.photo import Photo
from sensing.pixels.refine import INDEPENDENT, INEXACT, moved, refined
from sensing.pixels.sureness import RADIUS, Alternative, alternatives, share_of
from sensing.simulated.body import Body
from sensing.simulated.camera import Sensor, render
from sensing.simulated.surroundings import Light, Surroundings

TRIED = [(some, INEXACT) for some in (0.05, 0.2, 0.5, 1.0, 2.0, 5.0)] + [
    (INDEPENDENT, some) for some in (0, 0.5, 1.5, 2)
]
"""``INDEPENDENT`` and ``INEXACT``."""
BINS = 5
"""Of equal mass."""
AGAIN = 1000
FAR = np.array([1.0, 3.0])
"""Half of the starts are off by what print leaves in doubt, half by three times that."""
LOOSE = 0.15, 0.04, 0.02
"""Standard deviations of starts: radians, shares of the depth, and of the diameter across."""


class Sample(NamedTuple):
    """One refined pose: of which object, whether right, its ``alternatives``, and the truth's symmetries."""

    of: str
    right: bool
    found: list[Alternative]
    paint: Paint
    pose: Floats
    symmetries: Floats


def beside(true: Floats, paint: Paint, rng: np.random.Generator) -> Floats:
    """A pose near the true one."""
    middle = true[:3, :3] @ paint.middle + true[:3, 3]
    far = rng.choice(FAR)
    step = np.concatenate([rng.normal(0.0, far * LOOSE[0], 3), rng.normal(0.0, LOOSE[2] * paint.diameter, 3)])
    step[3:] += rng.normal(0.0, far * LOOSE[1]) * middle
    return moved(true, paint.middle, step)


def sample(photo: Photo, paint: Paint, kind: ObjectType, true: Floats, start: Floats, of: str) -> Sample | None:
    """What a start comes to."""
    at = refined(photo, paint, start)
    found = alternatives(photo, paint, at.pose) if at is not None and not at.hopeless else []
    if at is None or not found:
        return None
    return Sample(of, off(at.pose, true, paint, kind) < RADIUS, found, paint, at.pose, kind.symmetries)


def off(pose: Floats, true: Floats, paint: Paint, kind: ObjectType) -> float:
    """ADD, up to symmetry, in diameters."""
    here, places = transform_points(pose, paint.mesh.vertices), paint.mesh.vertices
    turned = [transform_points(true @ motion, places) for motion in kind.symmetries]
    return float(min(np.linalg.norm(here - there, axis=1).mean() for there in turned)) / paint.diameter


def simulated(types: dict[str, LearnedIndex], camera: Camera, count: int, seed: int) -> Iterator[Sample]:
    """One pose of each of ``count`` photos a type."""
    rng = np.random.default_rng(seed)
    eye = np.diag([1.0, -1.0, -1.0, 1.0])
    eye[2, 3] = 50.0  # the floor, z = 0, is far behind
    for name, index in types.items():
        paint = index.paint
        assert paint is not None  # noqa: S101 - those that have it
        for i in range(count):
            axis = rng.normal(size=3)
            turn = turn_about(axis / np.linalg.norm(axis), rng.uniform(0.0, np.pi))
            depth = camera.f * paint.diameter / rng.uniform(70.0, 220.0)
            middle = depth * np.array([*rng.uniform(-0.2, 0.2, 2), 1.0])
            true = from_rotation_translation(turn, middle - turn @ paint.middle)
            looks = Surroundings(contrast=float(rng.uniform(10, 60)), shadow=0, seed=int(rng.integers(2**31)))
            sensor = Sensor(noise=float(rng.uniform(1, 6)), blur=float(rng.uniform(0.3, 1.2)), seed=i)
            body = Body(name, paint.mesh, eye @ true)
            image = render([body], replace(camera, world_from_camera=eye), Light(), looks, sensor).image
            one = sample(Photo(image, camera), paint, index.object_type, true, beside(true, paint, rng), f"{name} {i}")
            if one is not None:
                yield one


def real(types: dict[str, LearnedIndex], dataset: Path, numbers: dict[str, int], count: int) -> Iterator[Sample]:
    """``count`` poses of each posed object of a dataset."""
    rng = np.random.default_rng(0)
    for photo, posed in photos(dataset, numbers):
        for name, true in posed:
            index = types[name]
            assert index.paint is not None  # noqa: S101 - those that have it
            for _ in range(count):
                start = beside(true, index.paint, rng)
                one = sample(photo, index.paint, index.object_type, true, start, f"{name} {true.tobytes()!r}")
                if one is not None:
                    yield one


def photos(dataset: Path, numbers: dict[str, int]) -> Iterator[tuple[Photo, list[tuple[str, Floats]]]]:
    """Each photo of a dataset with the posed objects of the types by name: name and ``camera_from_object``."""
    names = {number: name for name, number in numbers.items()}
    for shown in photos_of(open_dataset(dataset)):
        known = [truth for truth in shown.truths if truth.obj_id in names]
        yield Photo(shown.image, shown.camera), [(names[truth.obj_id], truth.camera_from_object) for truth in known]


def accepted(
    perceiver: Perceiver, types: dict[str, LearnedIndex], dataset: Path, numbers: dict[str, int]
) -> Iterator[tuple[float, float]]:
    """``pose_probability`` of what is accepted of posed types, and 1 where it is right, else 0."""
    for photo, posed in photos(dataset, numbers):
        gamma = detect(photo.image, photo.camera, perceiver.kb.sought, perceiver.kb.words)
        for row in perceiver(gamma, Options(), photo.image)["hypotheses"]:
            name, index = row["type"], types.get(row["type"])
            there = [true for other, true in posed if other == name]
            if row["status"] == "accepted" and "pose_probability" in row and index is not None and there:
                assert index.paint is not None  # noqa: S101 - those that have it
                pose = np.array(row["T_camera_object"])
                error = min(off(pose, true, index.paint, index.object_type) for true in there)
                print(f"  {name}: ADD {error:.3f}, P {row['pose_probability']:.3f}")  # noqa: T201 - a script
                yield row["pose_probability"], float(error < RADIUS)


def told(samples: list[Sample], independent: float, inexact: float) -> Floats:
    """(N,) P(right) of each."""
    return np.array([share_of(s.found, s.paint, s.pose, s.symmetries, independent, inexact) for s in samples])


def error(p: Floats, right: Floats) -> float:
    """Expected calibration error."""
    parts = np.array_split(np.argsort(p, kind="stable"), BINS)
    return float(sum(abs(p[some].mean() - right[some].mean()) * len(some) for some in parts if len(some)) / len(p))


def loss(p: Floats, right: Floats) -> float:
    """Mean logarithmic loss, nats."""
    p = np.clip(p, 0.005, 0.995)
    return float(-np.mean(np.where(right > 0, np.log(p), np.log(1.0 - p))))


def line(samples: list[Sample], scales: tuple[float, float]) -> str:
    """The figures of two scales."""
    p, right = told(samples, *scales), np.array([float(s.right) for s in samples])
    return f"{scales[0]:g}, {scales[1]:g}: {figures(p, right, [s.of for s in samples])}"


def figures(p: Floats, right: Floats, names: list[str]) -> str:
    """Log loss and calibration error, with the interval of the error where those of one name are drawn together."""
    rng = np.random.default_rng(0)
    of = np.unique(names, return_inverse=True)[1]
    again = []
    for _ in range(AGAIN):
        some = np.concatenate([np.flatnonzero(of == i) for i in rng.integers(0, of.max() + 1, of.max() + 1)])
        again.append(error(p[some], right[some]))
    low, high = np.percentile(again, [2.5, 97.5])
    means = f"mean P {p.mean():.3f}, right {right.mean():.3f}"
    return f"log loss {loss(p, right):.3f}, ECE {error(p, right):.3f} ({low:.3f} to {high:.3f}), {means}"


def main(kb_folder: str, dataset: Path, count: int) -> None:
    """Print it all."""
    perceiver = Perceiver(kb_of(kb_folder))
    types = {n: m for n, m in perceiver.models.items() if isinstance(m, LearnedIndex) and m.paint is not None}
    numbers = {name: number for name, number in numbers_of(perceiver.kb, dataset / "models").items() if name in types}
    camera = next(photos_of(open_dataset(dataset))).camera
    for name, some in (
        ("simulated, to calibrate", simulated(types, camera, count, seed=1)),
        ("simulated, to check", simulated(types, camera, count, seed=2)),
        ("real", real(types, dataset, numbers, count)),
    ):
        samples = list(some)
        objects = len({s.of for s in samples})
        print(f"{name}: {len(samples)} poses of {objects} objects; in use {INDEPENDENT:g}, {INEXACT:g}")  # noqa: T201 - a script
        for scales in TRIED:
            print("  " + line(samples, scales), flush=True)  # noqa: T201
    rows = np.array(list(accepted(perceiver, types, dataset, numbers))).reshape(-1, 2)
    print(f"accepted: {len(rows)}: {figures(rows[:, 0], rows[:, 1], [str(i) for i in range(len(rows))])}")  # noqa: T201


if __name__ == "__main__":
    parser = of_kb_and_dataset(__doc__)
    parser.add_argument("--count", type=int, default=6, help="photos a type, and poses an object of DATASET")
    asked = parser.parse_args()
    main(asked.kb, asked.dataset, asked.count)
