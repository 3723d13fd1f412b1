"""The BOP challenge's results file.

``scene_id,im_id,obj_id,score,R,t,time``, R row by row and t in millimetres, blanks between numbers.

Its name by the challenge's convention is METHOD_DATASET-SPLIT.csv; none is demanded here.

``run`` has a perceiver look at a dataset's frames, and gives the estimates with a line for each frame that went wrong.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.errors import PlogicError
from geometry.frames import is_rigid
from plogic.base.errors import InputError
from plogic.run.bop.dataset import Dataset
from plogic.run.bop.json_files import MM

HEADER = "scene_id,im_id,obj_id,score,R,t,time"
UNTIMED = -1.0
"""The time of an image that nobody measured."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """One pose found: ``camera_from_object`` (4, 4) m; the higher the ``score`` the surer.

    ``time`` s of the whole image, -1: unknown.
    """

    scene_id: int
    im_id: int
    obj_id: int
    score: float
    camera_from_object: NDArray[np.float64]
    time: float = UNTIMED


def results_text(estimates: Iterable[Estimate]) -> str:
    """The file's text; its numbers are read back as they were."""
    return "\n".join([HEADER, *(_line(e) for e in estimates)]) + "\n"


def _line(e: Estimate) -> str:
    R = " ".join(repr(float(x)) for x in e.camera_from_object[:3, :3].ravel())
    t = " ".join(repr(float(x) * MM) for x in e.camera_from_object[:3, 3])
    return f"{e.scene_id},{e.im_id},{e.obj_id},{float(e.score)!r},{R},{t},{float(e.time)!r}"


Look = Callable[["NDArray[np.uint8]", "Camera"], Sequence[tuple[str, "NDArray[np.float64]", float]]]
"""A picture (H, W, 3) uint8, blue first, and its camera to (type's name, ``T_camera_object`` (4, 4) m, score) of each
object found."""
Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Run:
    """``cameras``: of every frame that was looked at, by (scene, image).

    ``wrong``: one line each. ``frames``: how many there were.
    """

    estimates: tuple[Estimate, ...]
    cameras: Mapping[tuple[int, int], Camera]
    wrong: tuple[str, ...]
    frames: int


def run(
    dataset: Dataset,
    look: Look,
    ids: Mapping[str, int],
    say: Say,
    *,
    timed: bool = False,
    during: Callable[[str], AbstractContextManager[object]] = nullcontext,
) -> Run:
    """Look at every frame that is wanted; ``timed``: with the seconds of each, else -1.

    A bad frame is a line, never a stop. Each is looked at within what ``during`` makes of its name.
    """
    names, wrong = dataset.listed()
    for line in wrong:
        say(line)
    estimates: list[Estimate] = []
    cameras: dict[tuple[int, int], Camera] = {}
    for i, (scene_id, im_id) in enumerate(names, 1):
        here = f"{i}/{len(names)} scene {scene_id}, image {im_id}"
        try:
            with during(here):
                camera, found, seconds = _looked(dataset, scene_id, im_id, look)
        except PlogicError as error:
            wrong.append(f"{here}: {' '.join(str(error).split())}")
        except Exception as error:  # noqa: BLE001 - no frame may stop the others
            wrong.append(f"{here}: internal error: {type(error).__name__}: {' '.join(str(error).split())}")
        else:
            cameras[scene_id, im_id] = camera
            own = [
                Estimate(scene_id, im_id, ids[n], s, T, seconds if timed else UNTIMED) for n, T, s in found if n in ids
            ]
            estimates += own
            say(
                f"{here}: {len(own)} estimates"
                + (f", {len(found) - len(own)} without a BOP number" if len(own) < len(found) else "")
            )
            continue
        say(wrong[-1])
    return Run(tuple(estimates), cameras, tuple(wrong), len(names))


def _looked(
    dataset: Dataset, scene_id: int, im_id: int, look: Look
) -> tuple[Camera, list[tuple[str, NDArray[Any], float]], float]:
    frame = dataset.scene(scene_id).frame(im_id)
    start = perf_counter()
    found = [
        (name, np.asarray(pose, dtype=np.float64), float(sure)) for name, pose, sure in look(frame.image, frame.camera)
    ]
    for name, pose, sure in found:
        if not (is_rigid(pose) and np.isfinite(sure)):
            raise InputError(f"{name}: the perceiver gave no rigid pose with a finite score")
    return frame.camera, found, perf_counter() - start
