"""Recalls of BOP against ground truth.

Hodaň et al., BOP Challenge 2020 (§2.3): a measure's average recall is the mean of the recalls at ten thresholds:
AR_MSSD at 0.05, 0.10 … 0.50 of the object's diameter, AR_MSPD at 5, 10 … 50 px · r with r = width / 640. The
challenge's AR is the mean of AR_VSD, AR_MSSD and AR_MSPD; AR_VSD is not computed here, so that what is given beside
them is called the mean of the two and never AR. ADD(-S): recall at 0.1 of the diameter, by ADD-S for objects with
symmetries and by ADD for the others.

Errors of poses: P̂ the estimate, P̄ the truth, M the model's vertices, S its symmetries.

* MSSD, maximum symmetry-aware surface distance: min over S of max over x in M of ‖P̂x − P̄Sx‖
* MSPD, maximum symmetry-aware projection distance: min over S of max over x in M of ‖proj(P̂x) − proj(P̄Sx)‖, pixels
* ADD, average distance: mean over x in M of ‖P̂x − P̄x‖
* ADD-S (ADI), the same with indistinguishable views: mean over x in M of min over y in M of ‖P̄x − P̂y‖

MSSD and MSPD: Hodaň et al., BOP Challenge 2020 on 6D Object Localization (ECCVW 2020), §2.2. ADD and ADI:
Hinterstoisser et al., Model based training, detection and pose estimation of texture-less 3D objects in heavily
cluttered scenes (ACCV 2012). Poses and points share one unit, and the distances have it. In numpy, but for the nearest
neighbours of ADD-S, which scipy's tree finds. All functions broadcast over the leading axes of the two poses.

Which estimate is which object's (§2.1): of each object as many of the best-scored estimates are taken as instances are
wanted; by decreasing score each goes to the truth of the lowest error below the threshold that is still free.
``View`` is one image with what stands there and what was found: ``View(truths, estimates, camera, wanted={5: 1})``.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import pieces
from geometry.camera import Camera
from geometry.frames import inverse
from plogic.base.errors import InputError
from plogic.run.bop.dataset import Dataset, Truth
from plogic.run.bop.models import Model
from plogic.run.bop.results_file import Estimate, Run

VISIBLE = 0.1
"""A truth less visible than this is no target where no list of targets says how many are wanted."""


@dataclass(frozen=True, eq=False)
class View:
    """One image.

    ``camera`` may be None where there is no estimate. ``wanted``: instances by object; None: all that are visible.
    """

    truths: tuple[Truth, ...]
    estimates: tuple[Estimate, ...]
    camera: Camera | None
    wanted: Mapping[int, int] | None = None


def views_of(dataset: Dataset, done: Run) -> tuple[list[View], list[str]]:
    """The views with ground truth, bad frames (nothing found) among them, and a line for each unreadable truth."""
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


def targets_of(view: View) -> dict[int, list[Truth]]:
    """The truths to be found, by object.

    With ``wanted`` its number of the most visible, else those of which a tenth is visible.

    A truth of unknown visibility counts as visible.
    """
    chosen: dict[int, list[Truth]] = {}
    order = sorted(view.truths, key=lambda t: -(1.0 if t.visible is None else t.visible))
    for truth in order:
        mates = chosen.setdefault(truth.obj_id, [])
        seen = truth.visible is None or truth.visible >= VISIBLE
        if seen if view.wanted is None else len(mates) < view.wanted.get(truth.obj_id, 0):
            mates.append(truth)
    return {obj_id: mates for obj_id, mates in chosen.items() if mates}


def taken(view: View, obj_id: int, targets: int) -> list[Estimate]:
    """The estimates of an object that count: the best-scored, as many as instances are wanted.

    Among equals the first.
    """
    count = targets if view.wanted is None else view.wanted.get(obj_id, 0)
    return sorted((e for e in view.estimates if e.obj_id == obj_id), key=lambda e: -e.score)[:count]


def matched(errors: NDArray[np.float64] | Sequence[Sequence[float]], threshold: float) -> list[tuple[int, int]]:
    """(estimate, truth) pairs by ``errors`` (E, G), the estimates by decreasing score.

    An error must be below the threshold.
    """
    free = np.array(errors, dtype=np.float64)
    pairs = []
    for row in range(len(free)):
        best = int(np.argmin(free[row])) if free.shape[1] else -1
        if best >= 0 and free[row, best] < threshold:
            pairs.append((row, best))
            free[:, best] = np.inf
    return pairs


AT_ONCE = 2**19
"""Points that are moved in one go: it bounds the memory."""


def mssd(estimates: ArrayLike, truths: ArrayLike, points: ArrayLike, symmetries: ArrayLike) -> NDArray[np.float64]:
    """MSSD (...) of poses (..., 4, 4) for ``points`` (N, 3) and ``symmetries`` (S, 4, 4), the identity among them."""
    cloud, own = _points(points), _poses(symmetries)

    def one(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
        return min(
            float(np.linalg.norm(_moved(estimate - truth @ part, cloud), axis=-1).max(axis=1).min())
            for part in pieces(own, len(cloud), AT_ONCE)
        )

    return _each(one, estimates, truths)


def mspd(
    estimates: ArrayLike, truths: ArrayLike, points: ArrayLike, symmetries: ArrayLike, K: ArrayLike
) -> NDArray[np.float64]:
    """MSPD (...) px by the camera matrix ``K`` (3, 3).

    Inf where a vertex is not before the camera: it has no image there.
    """
    cloud, own, matrix = _points(points), _poses(symmetries), np.asarray(K, dtype=np.float64)

    def one(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
        seen = _projected(_moved(estimate[None], cloud), matrix)
        if not np.isfinite(seen).all():
            return np.inf
        parts = (_projected(_moved(truth @ part, cloud), matrix) for part in pieces(own, len(cloud), AT_ONCE))
        return min(
            float(np.nan_to_num(np.linalg.norm(seen - part, axis=-1), nan=np.inf).max(axis=1).min()) for part in parts
        )

    return _each(one, estimates, truths)


def add(estimates: ArrayLike, truths: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """ADD (...) of poses (..., 4, 4) for ``points`` (N, 3)."""
    cloud = _points(points)
    return _each(
        lambda estimate, truth: float(np.linalg.norm(_moved((estimate - truth)[None], cloud), axis=-1).mean()),
        estimates,
        truths,
    )


def add_s(estimates: ArrayLike, truths: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """ADD-S (...) of poses (..., 4, 4) for ``points`` (N, 3)."""
    from scipy.spatial import cKDTree

    cloud = _points(points)
    tree = cKDTree(cloud)

    def one(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
        """Distances are the same in the estimate's own frame, where one tree serves all."""
        return float(tree.query(_moved((inverse(estimate) @ truth)[None], cloud)[0])[0].mean())

    return _each(one, estimates, truths)


def _moved(motions: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (B, N, 3) of (N, 3) under affine motions (B, 4, 4); of a difference of two, how far they are apart."""
    return np.asarray(points @ np.swapaxes(motions[:, :3, :3], 1, 2) + motions[:, None, :3, 3])


def _projected(points: NDArray[np.float64], K: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (B, N, 2) of points (B, N, 3) in the camera frame; NaN where z is not positive."""
    depth = np.where(points[..., 2:] > 0, points[..., 2:], np.nan)
    return np.asarray((points / depth) @ K[:2].T)


def _each(
    error: Callable[[NDArray[np.float64], NDArray[np.float64]], float], estimates: ArrayLike, truths: ArrayLike
) -> NDArray[np.float64]:
    """The error (...) of each pair of poses, after broadcasting."""
    found, true = np.broadcast_arrays(_square(estimates), _square(truths))
    values = [error(a, b) for a, b in zip(found.reshape(-1, 4, 4), true.reshape(-1, 4, 4), strict=True)]
    return np.array(values, dtype=np.float64).reshape(found.shape[:-2])


def _square(poses: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(poses, dtype=np.float64)
    if array.shape[-2:] != (4, 4):
        raise ValueError(f"poses must have the shape (..., 4, 4), not {array.shape}")
    return array


def _poses(motions: ArrayLike) -> NDArray[np.float64]:
    return _square(motions).reshape(-1, 4, 4)


def _points(points: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or not len(array):
        raise ValueError(f"points must have the shape (N >= 1, 3), not {array.shape}")
    return array


TENTHS = np.arange(1, 11)
THRESHOLDS = {"MSSD": 0.05 * TENTHS, "MSPD": 5.0 * TENTHS, "ADD": np.array([0.1])}
"""MSSD and ADD(-S) by the diameter, MSPD in pixels of an image 640 wide."""
WIDTH = 640.0


@dataclass(frozen=True)
class Recalls:
    """Recalls over ``targets`` instances, None where there are none."""

    targets: int
    ar_mssd: float | None
    ar_mspd: float | None
    add: float | None

    @property
    def mean_of_the_two(self) -> float | None:
        """The mean of AR_MSSD and AR_MSPD: not BOP's AR, which has AR_VSD as well."""
        return None if self.ar_mssd is None or self.ar_mspd is None else (self.ar_mssd + self.ar_mspd) / 2


@dataclass(frozen=True)
class Scores:
    """All objects together and one by one.

    ``estimates``: all that were made. ``absent``: of these, of objects that are not in their image.
    """

    images: int
    estimates: int
    absent: int
    together: Recalls
    objects: Mapping[int, Recalls] = field(default_factory=dict)


def score(views: Iterable[View], models: Mapping[int, Model]) -> Scores:
    """The scores of all views; ``models`` has every object that is wanted in any."""
    targets: Counter[int] = Counter()
    hits: dict[str, Counter[tuple[int, int]]] = {name: Counter() for name in THRESHOLDS}
    images = estimates = absent = 0
    for view in views:
        there = {truth.obj_id for truth in view.truths}
        images, estimates = images + 1, estimates + len(view.estimates)
        absent += sum(e.obj_id not in there for e in view.estimates)
        for obj_id, truths in targets_of(view).items():
            targets[obj_id] += len(truths)
            found = taken(view, obj_id, len(truths))
            for name, table in _errors(found, truths, models[obj_id], view).items():
                for i, threshold in enumerate(THRESHOLDS[name]):
                    hits[name][obj_id, i] += len(matched(table, float(threshold)))
    rows = {obj_id: _recalls([obj_id], targets, hits) for obj_id in sorted(targets)}
    return Scores(images, estimates, absent, _recalls(sorted(targets), targets, hits), rows)


def _errors(
    found: Sequence[Estimate], truths: Sequence[Truth], model: Model, view: View
) -> dict[str, NDArray[np.float64]]:
    """(E, G) by measure, as the thresholds mean them; nothing without an estimate."""
    if not found or view.camera is None:
        return {}
    a = np.array([e.camera_from_object for e in found])[:, None]
    b = np.array([t.camera_from_object for t in truths])[None]
    distance = add_s if model.symmetric else add
    return {
        "MSSD": mssd(a, b, model.points, model.symmetries) / model.diameter,
        "MSPD": mspd(a, b, model.points, model.symmetries, view.camera.K) * WIDTH / view.camera.width,
        "ADD": distance(a, b, model.points) / model.diameter,
    }


def _recalls(ids: Sequence[int], targets: Mapping[int, int], hits: Mapping[str, Counter[tuple[int, int]]]) -> Recalls:
    """Recall over the instances of these objects together, averaged over each measure's thresholds."""
    wanted = sum(targets[obj_id] for obj_id in ids)
    if not wanted:
        return Recalls(0, None, None, None)

    def average(name: str) -> float:
        count = len(THRESHOLDS[name])
        return sum(hits[name][obj_id, i] for obj_id in ids for i in range(count)) / (wanted * count)

    return Recalls(wanted, average("MSSD"), average("MSPD"), average("ADD"))
