"""Errors of poses: P̂ the estimate, P̄ the truth, M the model's vertices, S its symmetries.

* MSSD, maximum symmetry-aware surface distance: min over S of max over x in M of ‖P̂x − P̄Sx‖
* MSPD, maximum symmetry-aware projection distance: min over S of max over x in M of ‖proj(P̂x) − proj(P̄Sx)‖, pixels
* ADD, average distance: mean over x in M of ‖P̂x − P̄x‖
* ADD-S (ADI), the same with indistinguishable views: mean over x in M of min over y in M of ‖P̄x − P̂y‖

MSSD and MSPD: Hodaň et al., BOP Challenge 2020 on 6D Object Localization (ECCVW 2020), §2.2. ADD and ADI:
Hinterstoisser et al., Model based training, detection and pose estimation of texture-less 3D objects in heavily
cluttered scenes (ACCV 2012). Poses and points share one unit, and the distances have it. In numpy, but for the nearest
neighbours of ADD-S, which scipy's tree finds. All functions broadcast over the leading axes of the two poses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

AT_ONCE = 2**19
"""Points that are moved in one go: it bounds the memory."""


def mssd(estimates: ArrayLike, truths: ArrayLike, points: ArrayLike, symmetries: ArrayLike) -> NDArray[np.float64]:
    """MSSD (...) of poses (..., 4, 4) for ``points`` (N, 3) and ``symmetries`` (S, 4, 4), the identity among them."""
    cloud, own = _points(points), _poses(symmetries)

    def one(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
        return min(
            float(np.linalg.norm(_moved(estimate - truth @ part, cloud), axis=-1).max(axis=1).min())
            for part in _parts(own, len(cloud))
        )

    return _each(one, estimates, truths)


def mspd(
    estimates: ArrayLike, truths: ArrayLike, points: ArrayLike, symmetries: ArrayLike, K: ArrayLike
) -> NDArray[np.float64]:
    """MSPD (...) px by the camera matrix ``K`` (3, 3); inf where a vertex is not before the camera: it has no image there."""
    cloud, own, matrix = _points(points), _poses(symmetries), np.asarray(K, dtype=np.float64)

    def one(estimate: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
        seen = _projected(_moved(estimate[None], cloud), matrix)
        if not np.isfinite(seen).all():
            return np.inf
        parts = (_projected(_moved(truth @ part, cloud), matrix) for part in _parts(own, len(cloud)))
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


def _parts(rows: NDArray[np.float64], each: int) -> list[NDArray[np.float64]]:
    """``rows`` (S, ...) cut so that no part makes more than ``AT_ONCE`` points where one makes ``each``."""
    size = max(1, AT_ONCE // max(each, 1))
    return [rows[i : i + size] for i in range(0, len(rows), size)]


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
