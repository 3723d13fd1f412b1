"""What the processes of ``plogic kb learn`` do: a type's views, its cloud, and the turns that its texture keeps.

Rendered from all around, and looked at with the detector of run time. All that decides a cloud is here or imported
from here.

* ``Task``: a type as far as a process must know it; ``Step``: a piece of the work, which ``done`` does
"""

import hashlib
from collections.abc import Callable, Sequence
from functools import cache, lru_cache, partial
from importlib.metadata import version
from typing import Any, NamedTuple

from geometry.arrays import Bytes, Floats, Ints, Mask
from geometry.cones import even_directions
from geometry.files.remembered import ROOT, source_digest, sources
from kb.clouds.learned import cloud_bytes, read_cloud
from kb.learning.again import Like
from kb.learning.features import cloud_of
from kb.learning.observations import AWAY, DIRECTIONS, MARGIN, PIXELS, Detect, Observations, joined, observed
from kb.learning.photo import PaintedMesh, on_shown
from kb.learning.symmetry_trials import DIRECTIONS as NEW
from kb.learning.symmetry_trials import Trial, judged, trials
from kb.surfaces.surface import Surface
from sensing.detectors.keypoint_detector import EdgeSides, described, edge_sides
from sensing.detectors.keypoints import Keypoints
from sensing.pixels.turntable import turned
from sensing.simulated.body import TexturedMesh, read_mesh
from sensing.simulated.camera import extent

CHUNK = 15
"""Directions that a process renders at a time."""


class Task(NamedTuple):
    """A mesh file, its unit (m), the detector that looks, and the seed of the noise."""

    file: str
    scale: float
    detector: str
    seed: int


class Step(NamedTuple):
    """A type's name, what is done, and of views which: what a process is given."""

    name: str
    call: Callable[[], Any]
    part: range = range(0)


def done(step: Step) -> Any:  # noqa: ANN401 - whatever its call gives
    """Do it, by one thread of OpenCV's: the processes share the processors."""
    import cv2

    cv2.setNumThreads(1)
    return step.call()


def looks(name: str, task: Task) -> list[Step]:
    """All views of a type, in parts."""
    parts = [range(start, min(start + CHUNK, DIRECTIONS)) for start in range(0, DIRECTIONS, CHUNK)]
    return [Step(name, partial(look, task, part), part) for part in parts]


def look(task: Task, part: range) -> list[Observations]:
    """What is seen from some directions, in their order. Raises SensingError where the mesh cannot be drawn."""
    views = turned(_mesh(task), [even_directions(DIRECTIONS)[i] for i in part], PIXELS[0], MARGIN, AWAY)
    sides, detect = sides_where if task.detector == "sift" else None, detection_by(task.detector)
    return [observed(view, number, detect, task.seed, sides) for number, view in zip(part, views, strict=True)]


@lru_cache(maxsize=1)
def _mesh(task: Task) -> TexturedMesh:
    return read_mesh(task.file, task.scale)


def fitted(task: Task, f_ref: float, painted: PaintedMesh | None, seen: Sequence[Observations]) -> bytes | None:
    """The file of the cloud of a type, by what is seen of it from all directions; None where that is nothing.

    Of one ``painted`` with a photo, only of what the photo shows.
    """
    whole = joined(seen)
    diameter = extent(_mesh(task).vertices)[1]
    cloud = cloud_of(whole if painted is None else on_shown(painted, whole), diameter, f_ref, DIRECTIONS)
    return cloud_bytes(cloud) if len(cloud.at) else None


def turns_tried(task: Task, vertices: Floats, triangles: Ints, cloud: bytes) -> list[Trial]:
    """A trial for each turn of the type's shape, of ``vertices`` (V, 3) m and ``triangles`` (T, 3).

    New pictures of it are taken where the cloud alone does not rule all of them out.
    """
    points, directions = read_cloud(cloud).keypoints, even_directions(NEW)
    groups = trials(points, Surface(vertices, triangles))
    if not any(trial.likely for group in groups for trial in group):
        return judged(groups, points, None, directions)
    views, detect = turned(_mesh(task), list(directions), PIXELS[0], MARGIN, AWAY), detection_by(task.detector)
    seen = [observed(view, number, detect, task.seed + 1) for number, view in enumerate(views)]
    return judged(groups, points, joined(seen), directions)


def detection_by(detector: str) -> Detect:
    """Return ``described`` with a detector, and its arguments as ``observed`` hands them over."""

    def detect(image: Bytes, calm: Bytes, cell: int, where: Mask, like: Like | None) -> Keypoints:
        return described(image, detector, cell=cell, calm=calm, where=where, like=like)

    return detect


def sides_where(image: Bytes, cell: int, where: Mask) -> EdgeSides:
    """Return ``edge_sides``, its arguments as ``observed`` hands them over."""
    return edge_sides(image, cell, where=where)


DECIDES = "plogic/face/authoring/kb_learn_look.py"
"""What makes a cloud, with all that it imports."""
LIBRARIES = ("numpy", "numba", "scipy", "embreex", "trimesh")
"""They read, render and compute. OpenCV, which detects, comes under several names."""


def key_of(mesh: TexturedMesh, how: tuple[Any, ...]) -> str:
    """SHA-256 over a painted mesh, ``how`` it is learned, the source that learns, and the libraries' versions."""
    import cv2

    total = hashlib.sha256(repr((how, cv2.__version__, [version(name) for name in LIBRARIES])).encode())
    total.update(source_digest(ROOT, _deciding()))
    for array in (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture):
        total.update(b"-" if array is None else repr(array.shape).encode() + array.tobytes())
    return total.hexdigest()


@cache
def _deciding() -> set[str]:
    """The source files that decide a cloud."""
    return sources(ROOT, DECIDES)
