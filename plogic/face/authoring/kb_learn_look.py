"""What ``plogic kb learn`` does for one type.

Render it from all around, look with the detector of run time, and make a cloud of what was seen.

All that decides a cloud is here or imported from here.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import closing, suppress
from functools import cache, partial
from importlib.metadata import version
from typing import Any

from geometry.arrays import Bytes, Mask
from geometry.cones import even_directions
from geometry.files.remembered import ROOT, cache_folder, forget_files_beside, source_digest, sources
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud, cloud_bytes, read_cloud
from kb.errors import CloudError
from kb.learning.features import cloud_of
from kb.learning.observations import AWAY, DIRECTIONS, MARGIN, PIXELS, Observations, joined, observed
from kb.learning.photo import PaintedMesh, on_shown
from kb.shown.cautions import compound_sizes, compounds_text
from plogic.base.errors import InputError
from plogic.base.jobs import ChildDiedError, afresh
from plogic.face.shown.options import Learning
from plogic.face.shown.progress import Work
from sensing.detectors.keypoint_detector import EdgeSides, described, edge_sides
from sensing.detectors.keypoints import Keypoints
from sensing.errors import SensingError
from sensing.files.whole_files import write_whole
from sensing.simulated.body import TexturedMesh, read_mesh
from sensing.simulated.camera import extent, turned
from sensing.simulated.physics import physics_version

CHUNK = 10
"""Directions that a process renders at a time."""
FITTED = 8.0
"""What it takes to make a cloud of what was seen, in views: 8 s where 80 views take 100 s by two processes."""
LOOKED = DIRECTIONS + FITTED
"""What a type takes, in views (``Work``)."""


class NoPrintError(InputError):
    """A type shows nothing that could be learned; ``why``: the message without the type's name."""

    def __init__(self, name: str, why: str) -> None:
        super().__init__(f"{name}: {why}")
        self.why = why


def looked(
    kind: ObjectType,
    kb: KnowledgeBase,
    options: Learning,
    work: Work,
    painted: PaintedMesh | None = None,
) -> LearnedCloud:
    """The cloud of a type, rendered from its mesh file; of one ``painted`` with a photo, only of what the photo shows.

    Raises:
        NoPrintError: nothing of it comes again from view to view. InputError: a process died. SensingError: the mesh
        cannot be drawn.
    """
    assert kind.mesh_file is not None  # noqa: S101 - the caller looked
    task = (str(kind.mesh_file), kind.mesh_scale, options.detector, options.seed)
    whole = joined(_seen(kind.name, task, DIRECTIONS, options.jobs, work))
    work.at(f"{kind.name}: features")
    diameter = extent(read_mesh(kind.mesh_file, kind.mesh_scale).vertices)[1]
    cloud = cloud_of(whole if painted is None else on_shown(painted, whole), diameter, kb.f_ref, DIRECTIONS)
    if not len(cloud.at):
        raise NoPrintError(
            kind.name,
            f"no keypoint of it comes again from view to view: its texture is too plain for {options.detector}; "
            "write junctions, patches, markers or colour blobs into object.yaml by hand",
        )
    work.step(FITTED)
    compounds, together, largest = compound_sizes(cloud)
    groups = f", {together} of them in {compounds_text(compounds, largest)}" if compounds else ""
    work.say(f"{kind.name}: {len(cloud.at)} features{groups}, {len(cloud.feature)} appearances")
    return cloud


def _seen(name: str, task: tuple[str, float, str, int], count: int, jobs: int, work: Work) -> list[Observations]:
    """What is seen from ``count`` directions, in their order."""
    parts = [range(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]
    seen: list[Observations] = []
    work.at(f"{name}: 0 of {count} views")
    try:
        # a forked process would inherit the locks of OpenCV's threads, and wait for them for ever
        with closing(afresh(partial(_look, task), parts, jobs)) as found:
            for part, some in zip(parts, found, strict=True):
                seen += some
                work.at(f"{name}: {part.stop} of {count} views")
                work.step(len(part))
    except ChildDiedError:
        raise InputError(
            f"{name}: a process that rendered it was killed, as for lack of memory: fewer --jobs than {jobs}?"
        ) from None
    return seen


def _look(task: tuple[str, float, str, int], part: range) -> list[Observations]:
    """In a process of its own: render from some directions, and look."""
    import cv2

    cv2.setNumThreads(1)
    file, scale, detector, seed = task
    views = turned(read_mesh(file, scale), [even_directions(DIRECTIONS)[i] for i in part], PIXELS[0], MARGIN, AWAY)
    look = sides_where if detector == "sift" else None
    return [
        observed(view, number, detection_by(detector), seed, look) for number, view in zip(part, views, strict=True)
    ]


def detection_by(detector: str) -> Callable[[Bytes, Bytes, int, Mask], Keypoints]:
    """Return ``described`` with a detector, and its arguments as ``observed`` hands them over."""

    def detect(image: Bytes, calm: Bytes, cell: int, where: Mask) -> Keypoints:
        return described(image, detector, cell=cell, calm=calm, where=where)

    return detect


def sides_where(image: Bytes, cell: int, where: Mask) -> EdgeSides:
    """Return ``edge_sides``, its arguments as ``observed`` hands them over."""
    return edge_sides(image, cell, where=where)


DECIDES = "plogic/face/authoring/kb_learn_look.py"
"""What makes a cloud, with all that it imports."""
LIBRARIES = ("numpy", "scipy", "embreex", "trimesh")
"""They read, render and compute. OpenCV, which detects, and pybullet, which draws where it is installed, come under
several names."""


def learned_of(
    kind: ObjectType,
    kb: KnowledgeBase,
    options: Learning,
    work: Work,
    painted: PaintedMesh | None = None,
) -> LearnedCloud:
    """The cloud of a type from the cache, or learned and put there; raises as ``looked`` does."""
    assert kind.mesh_file is not None  # noqa: S101 - the caller looked
    folder = cache_folder("clouds")
    if folder is None:
        work.say(
            f"{kind.name}: is not remembered for the next time: there is no home folder; XDG_CACHE_HOME may name another"
        )
        return read_cloud(cloud_bytes(looked(kind, kb, options, work, painted)))
    how = (kb.f_ref, options.detector, options.seed, painted is not None)
    place = folder / f"{key_of(read_mesh(kind.mesh_file, kind.mesh_scale), how)}.npz"
    try:
        remembered = _kept(place.read_bytes())
    except (OSError, CloudError):
        content = cloud_bytes(looked(kind, kb, options, work, painted))
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_whole(place, content)
            forget_files_beside(place)
        except (OSError, SensingError) as error:
            work.say(f"{kind.name}: is not remembered for the next time: {error}")
        return read_cloud(content)  # in the file's precision, as it will come the next time: equal hit rates stay equal
    with suppress(OSError):  # who may only read it uses it all the same
        os.utime(place)
    work.say(f"{kind.name}: was learned before ({place})")
    work.skip(LOOKED)
    return remembered


def _kept(content: bytes) -> LearnedCloud:
    """The cloud of a file; raises CloudError where it is not what was written.

    An archive's own checksums are of its arrays, not of their names.
    """
    cloud = read_cloud(content)
    if cloud_bytes(cloud) != content:
        raise CloudError("is not what was written")
    return cloud


def key_of(mesh: TexturedMesh, how: tuple[Any, ...]) -> str:
    """SHA-256 over a painted mesh, ``how`` it is learned, the source that learns, and the libraries' versions."""
    import cv2

    total = hashlib.sha256(
        repr((how, cv2.__version__, physics_version(), [version(name) for name in LIBRARIES])).encode()
    )
    total.update(source_digest(ROOT, _deciding()))
    for array in (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture):
        total.update(b"-" if array is None else repr(array.shape).encode() + array.tobytes())
    return total.hexdigest()


@cache
def _deciding() -> set[str]:
    """The source files that decide a cloud."""
    return sources(ROOT, DECIDES)
