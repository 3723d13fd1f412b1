"""How far down the list of what views suggest the right pose comes, as they are searched for and otherwise.

``python benchmarks/view_seeds.py KB DATASET``: the types of KB are those of DATASET, real photos in BOP's layout, by
number or by name. For each posed object of which a tenth is visible its type is looked for by its views
(``sensing.views``), whatever print it has; the first pose counts that is within 25°, up to symmetry, 15 % of the depth,
and 15 % of its size in the picture of its place. Prints how many have it among the first 1, 3, 10 and 50, and the
seconds of processor of a type, with the constants in use and with one of them changed at a time; and the same of the
search on the plane that the true poses of a photo speak for (``sensing.views.standing``), by views and as pixels order
what these suggest there, with what views tell counted so much (``plogic.match.learned.learned_pixels``, ``TOO``).
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import process_time
from types import ModuleType

import numpy as np

from benchmarks.photos.answers import Shown, photos_of
from benchmarks.photos.knowledge import numbers_of
from benchmarks.photos.planes import true_plane
from benchmarks.photos.score import Posed
from benchmarks.pixel_odds import paints_of
from benchmarks.shared.arguments import of_kb_and_dataset
from geometry.arrays import Floats
from geometry.bodies.standing import Known
from geometry.files.remembered import cache_folder
from geometry.frames import rotation_angle, transform_points
from kb.clouds.cloud import ObjectType
from plogic.base.jobs import each, processors
from plogic.match.learned import learned_pixels
from plogic.match.learned.learned_pixels import Seen, by_odds
from plogic.match.learned.learned_views import PROPOSED_ON, VIEWS
from plogic.run.bop.dataset import open_dataset
from plogic.run.perceive import Perceiver
from plogic.run.sources import kb_of
from sensing.pixels.photo import Photo
from sensing.views import search
from sensing.views.kept import kept_views
from sensing.views.maps import PhotoMaps, TypeMaps
from sensing.views.search import Body, searched, share_maps
from sensing.views.standing import stood

ANGLE, SHARE = np.radians(25.0), 0.15
FIRST = 1, 3, 10, 50
WORTHS = 0.0, 0.02, 0.05, 0.2
OTHERWISE: tuple[dict[str, object], ...] = (
    {},
    {"LAID": 100},
    {"TURNS": 10},
    {"TURNS": 18},
    {"SIZES": (40.0, 300.0, 1.2)},
    {"SPREAD": 3},
    {"SPREAD_FINE": 2},
    {"SEEDS": 200},
    {"LAID": 60, "SEEDS": 800},
)


@contextmanager
def constants(changed: dict[str, object], module: ModuleType = search) -> Iterator[None]:
    """The search with some of its constants changed."""
    with ExitStack() as back:
        for name, value in changed.items():
            back.callback(setattr, module, name, getattr(module, name))
            setattr(module, name, value)
        yield


def rank(poses: Floats, truth: Posed, kind: ObjectType, body: Body, focal: float) -> int:
    """Of poses (N, 4, 4) which is the first right one; ``FIRST[-1]`` where none is."""
    true = truth.camera_from_object
    angle = np.min(
        [rotation_angle(poses[:, :3, :3].transpose(0, 2, 1) @ (true @ m)[:3, :3]) for m in kind.symmetries], 0
    )
    here = np.stack([transform_points(pose, body.middle[None])[0] for pose in poses])
    there = transform_points(true, body.middle[None])[0]
    across = np.linalg.norm(here[:, :2] / here[:, 2:] - there[:2] / there[2], axis=1) * focal
    size = focal * body.diameter / there[2]
    right = (angle < ANGLE) & (np.abs(here[:, 2] / there[2] - 1.0) < SHARE) & (across < SHARE * size)
    return int(right.argmax()) if right.any() else FIRST[-1]


def main(kb_folder: str, dataset: Path) -> None:
    """Print it all."""
    kb, opened = kb_of(kb_folder), open_dataset(dataset)
    assert opened.models is not None  # noqa: S101 - it is a whole dataset
    numbers = numbers_of(kb, opened.models)
    kinds = {numbers[kind.name]: kind for kind in kb.types}
    perceiver = Perceiver(replace(kb, maybe=True))
    paints = {numbers[name]: paint for name, paint in paints_of(perceiver).items()}
    start = process_time()
    bodies = {
        n: Body(kept_views(paint, VIEWS, cache_folder("views")), paint.middle, paint.diameter)
        for n, paint in paints.items()
    }
    print(f"views {(process_time() - start) / len(bodies):.2f} s a type, less where they are kept")  # noqa: T201

    names = {number: kind.name for number, kind in kinds.items()}

    def looked(shown: Shown) -> list[tuple[int, float]]:
        maps = PhotoMaps(shown.image)
        share_maps(maps)
        rows = []
        for truth in (truth for truth in shown.truths if truth.obj_id in bodies):
            body, began = bodies[truth.obj_id], process_time()
            poses, _ = searched(maps, shown.camera, body, FIRST[-1])
            spent = process_time() - began
            rows.append((rank(poses, truth, kinds[truth.obj_id], body, shown.camera.f), spent))
        return rows

    def stand(shown: Shown) -> list[list[tuple[int, float]]]:
        plane = true_plane(shown, names, perceiver.models, perceiver.kb)
        if plane is None:
            return []
        maps, photo, rows = PhotoMaps(shown.image), Photo(shown.image, shown.camera), []
        share_maps(maps)
        for truth in (truth for truth in shown.truths if truth.obj_id in bodies):
            body, paint, began = bodies[truth.obj_id], paints[truth.obj_id], process_time()
            faces = perceiver.models[names[truth.obj_id]].resting
            mine, known = TypeMaps(maps, body.views), Known(plane, np.eye(3))
            seen = Seen(*stood(mine, shown.camera, body, known, faces, PROPOSED_ON))
            ways = [(seen.poses, process_time() - began)]
            for worth in WORTHS:
                with constants({"TOO": worth}, learned_pixels):
                    began = process_time()
                    ordered = np.reshape([pose for _, pose in by_odds(photo, paint, seen)], (-1, 4, 4))
                    ways.append((ordered, process_time() - began))
            rows.append([(rank(p, truth, kinds[truth.obj_id], body, shown.camera.f), spent) for p, spent in ways])
        return rows

    shown_all = list(photos_of(opened))
    on_planes = [row for some in each(stand, shown_all, processors()) for row in some]
    for k, said in enumerate(("by views", *(f"by pixels, TOO = {worth}" for worth in WORTHS))):
        tell(f"on the true plane, {said}", [row[k] for row in on_planes])
    for changed in OTHERWISE:
        with constants(changed):
            rows = [row for some in each(looked, shown_all, processors()) for row in some]
        tell(", ".join(f"{name} = {value}" for name, value in changed.items()) or "as in use", rows)


def tell(said: str, rows: list[tuple[int, float]]) -> None:
    """Print how far down the right ones are, and the seconds."""
    among = ", ".join(f"{sum(r < n for r, _ in rows)} among {n}" for n in FIRST)
    print(f"{said}: of {len(rows)} {among}; {median(s for _, s in rows):.2f} s a type", flush=True)  # noqa: T201


if __name__ == "__main__":
    parser = of_kb_and_dataset(__doc__)
    asked = parser.parse_args()
    main(asked.kb, asked.dataset)
