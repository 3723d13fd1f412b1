"""A perceiver over a dataset's frames: estimates, and a line for each frame that went wrong.

Then the views that are scored.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.errors import PlogicError
from geometry.frames import is_rigid
from plogic.base.errors import InputError
from plogic.run.bop.matching import View
from plogic.run.bop.results_file import UNTIMED, Estimate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from plogic.run.bop.dataset import Dataset

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


def run(dataset: Dataset, look: Look, ids: Mapping[str, int], say: Say, *, timed: bool = False) -> Run:
    """Look at every frame that is wanted; ``timed``: with the seconds of each, else -1.

    A bad frame is a line, never a stop.
    """
    names, wrong = dataset.listed()
    for line in wrong:
        say(line)
    estimates: list[Estimate] = []
    cameras: dict[tuple[int, int], Camera] = {}
    for i, (scene_id, im_id) in enumerate(names, 1):
        here = f"{i}/{len(names)} scene {scene_id}, image {im_id}"
        try:
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


def views_of(dataset: Dataset, done: Run) -> tuple[list[View], list[str]]:
    """The views that have ground truth, those of bad frames (nothing found) among them, and a line for each truth that cannot be read."""
    found: dict[tuple[int, int], list[Estimate]] = {}
    for e in done.estimates:
        found.setdefault((e.scene_id, e.im_id), []).append(e)
    views, wrong = [], []
    for key in dataset.listed()[0]:
        try:
            truths = dataset.scene(key[0]).truths(key[1])
        except InputError as error:
            wrong.append(str(error))
            continue
        if truths is not None:
            wanted = None if dataset.targets is None else dataset.targets[key]
            views.append(View(truths, tuple(found.get(key, ())), done.cameras.get(key), wanted))
    return views, list(dict.fromkeys(wrong))
