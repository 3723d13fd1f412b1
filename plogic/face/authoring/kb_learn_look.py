"""What ``plogic kb learn`` does for one type: render it from all around, look with the detector of run time, and make a cloud of what was seen.

All that decides a cloud is here or imported from here (``kb_learn_cache``).
"""

from __future__ import annotations

import sys
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError
from plogic.base.jobs import ChildDiedError, afresh

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from kb.clouds.learned import LearnedCloud
    from kb.learning.observations import Observations
    from kb.learning.photo import PaintedMesh
    from sensing.detectors.keypoints import Keypoints

CHUNK = 20
"""Directions that a process renders at a time."""


def looked(
    kind: ObjectType,
    kb: KnowledgeBase,
    options: Mapping[str, Any],
    say: Callable[[str], None],
    painted: PaintedMesh | None = None,
) -> LearnedCloud:
    """The cloud of a type, rendered from its mesh file; of one ``painted`` with a photo, only of what the photo shows.

    Raises:
        InputError: nothing of it comes again from view to view, or a process died. SensingError: the mesh cannot be
        drawn.
    """
    from kb.learning.features import cloud_of
    from kb.learning.observations import DIRECTIONS, joined
    from kb.learning.photo import on_shown
    from kb.shown.cautions import compound_sizes, compounds_text
    from sensing.simulated.body import read_mesh
    from sensing.simulated.camera import extent

    assert kind.mesh_file is not None  # noqa: S101 - the caller looked
    task = (str(kind.mesh_file), kind.mesh_scale, options["detector"], options["seed"])
    whole = joined(_seen(kind.name, task, DIRECTIONS, options["jobs"]))
    diameter = extent(read_mesh(kind.mesh_file, kind.mesh_scale).vertices)[1]
    cloud = cloud_of(whole if painted is None else on_shown(painted, whole), diameter, kb.f_ref, DIRECTIONS)
    if not len(cloud.at):
        raise InputError(
            f"{kind.name}: no keypoint of it comes again from view to view: its texture is too plain for {options['detector']}"
        )
    compounds, together, largest = compound_sizes(cloud)
    groups = f", {together} of them in {compounds_text(compounds, largest)}" if compounds else ""
    say(f"{kind.name}: {len(cloud.at)} features{groups}, {len(cloud.feature)} appearances")
    return cloud


def _seen(name: str, task: tuple[str, float, str, int], count: int, jobs: int) -> list[Observations]:
    """What is seen from ``count`` directions, in their order."""
    parts = [range(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]
    seen: list[Observations] = []
    try:
        # a forked process would inherit the locks of OpenCV's threads, and wait for them for ever
        with closing(afresh(partial(_look, task), parts, jobs)) as found:
            for part, some in zip(parts, found, strict=True):
                seen += some
                _progress(f"{name}: {part.stop} of {count} views")
    except ChildDiedError:
        raise InputError(
            f"{name}: a process that rendered it was killed, as for lack of memory: fewer --jobs than {jobs}?"
        ) from None
    finally:
        _progress("")
    return seen


def _look(task: tuple[str, float, str, int], part: range) -> list[Observations]:
    """In a process of its own: render from some directions, and look."""
    import cv2

    from geometry.cones import even_directions
    from kb.learning.observations import AWAY, DIRECTIONS, MARGIN, PIXELS, observed
    from sensing.detectors.edge_sides import edge_sides
    from sensing.detectors.keypoint_detector import described
    from sensing.simulated.body import read_mesh
    from sensing.simulated.camera import turned

    cv2.setNumThreads(1)
    file, scale, detector, seed = task

    def detect(image: NDArray[np.uint8], calm: NDArray[np.uint8], cell: int) -> Keypoints:
        return described(image, detector, cell=cell, calm=calm)

    views = turned(read_mesh(file, scale), [even_directions(DIRECTIONS)[i] for i in part], PIXELS[0], MARGIN, AWAY)
    look = edge_sides if detector == "sift" else None
    return [observed(view, number, detect, seed, look) for number, view in zip(part, views, strict=True)]


def _progress(text: str) -> None:
    """One line that is written over, on a terminal only."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r{text}\033[K")
        sys.stderr.flush()
