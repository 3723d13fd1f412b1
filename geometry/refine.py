"""Least-squares refinement of poses on all their inliers: Levenberg-Marquardt on SE(3), a batch at once.

A step (w, v) turns the object by exp(w) about its own origin, in the camera's axes, and moves that origin by v. The
residuals are undistorted pixels, so that the Jacobian is that of a pinhole, whatever the lens.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import Floats, last_axes
from geometry.camera import NEAREST, Camera
from geometry.errors import GeometryError

_GENTLE, _STRONG = 1e-4, 1e8  # damping at the start, and at its most
_FEW = 4  # steps of poses that are refined again


class _Task(NamedTuple):
    points: Floats  # (B, N, 3) m, object frame
    pixels: Floats  # (B, N, 2) undistorted px
    weights: Floats  # (B, N), 0 for a missing point
    K: Floats  # (2, 3)
    huber: float  # px
    onto: Floats | None  # (B, N, 2, 2), what of an offset counts


def refine_poses(
    camera_from_object: ArrayLike,
    points: ArrayLike,
    uv: ArrayLike,
    weights: ArrayLike,
    camera: Camera,
    iterations: int = 8,
    *,
    huber: float | None = None,
    across: ArrayLike | None = None,
) -> tuple[Floats, Floats, Floats]:
    """Poses (B, 4, 4) that reproject `points` (B, N, 3) m nearest to the pixels `uv` (B, N, 2), from those given.

    `weights` (B, N) are 1/variance in 1/px^2 (or plain 1); a point of weight 0 is missing and may be NaN. `huber` (px)
    makes residuals beyond it count linearly. `across` (B, N, 2), where it is given, holds unit vectors across the lines
    that points may lie anywhere along, or NaN for a point that is to be met. No pose gets worse than it came.

    Returns:
        The poses; the weighted rms distance (B,) in px (inf where a point of weight lies behind the camera, NaN without
        any weight); the covariance (B, 6, 6) of (w rad, v m) as 1/variance weights imply it, inf on the diagonal where
        the points do not fix the pose.

    Raises:
        GeometryError: where the shapes do not fit, or a weight is negative or not finite.
    """
    poses = np.array(last_axes(camera_from_object, (4, 4), "camera_from_object"))
    task = _task(poses, points, uv, weights, camera, np.inf if huber is None else huber, across)
    poses = _descended(poses, task, np.eye(6), iterations)
    return poses, _rms(poses, task), _covariance(_normal_equations(_seen(poses, task), task)[0])


def refine_along(
    camera_from_object: ArrayLike,
    points: ArrayLike,
    uv: ArrayLike,
    weights: ArrayLike,
    camera: Camera,
    moves: ArrayLike | None = None,
    *,
    huber: float | None = None,
    across: ArrayLike | None = None,
) -> Floats:
    """The poses (B, 4, 4) of `refine_poses`, after a few steps; where `moves` (6, M) are given each step (w, v) is a combination of its columns.

    Raises:
        GeometryError: where the shapes do not fit, or a weight is negative or not finite.
    """
    poses = np.array(last_axes(camera_from_object, (4, 4), "camera_from_object"))
    task = _task(poses, points, uv, weights, camera, np.inf if huber is None else huber, across)
    return _descended(poses, task, np.eye(6) if moves is None else last_axes(moves, (6, -1), "moves"), _FEW)


def _descended(poses: Floats, task: _Task, ways: Floats, iterations: int) -> Floats:
    """Poses (B, 4, 4) after so many damped steps along `ways` (6, M), those that make them worse left out."""
    here, damping = _seen(poses, task), np.full(len(poses), _GENTLE)
    cost = _cost(here, task)
    for _ in range(iterations):
        hessian, slope = _normal_equations(here, task)
        step = _solve(ways.T @ hessian @ ways, slope @ ways, damping) @ ways.T
        trial = _moved(poses, step)
        there = _seen(trial, task)
        trial_cost = _cost(there, task)
        better = trial_cost < cost
        poses = np.where(better[:, None, None], trial, poses)
        here = there if better.all() else _Seen(*(_chosen(better, its, own) for its, own in zip(there, here, strict=True)))
        cost = np.where(better, trial_cost, cost)
        damping = np.where(better, damping * 0.2, np.minimum(damping * 10, _STRONG))
        if np.abs(step[better]).max(initial=0.0) < 1e-12:
            break
    return poses


def _task(
    poses: Floats, points: ArrayLike, uv: ArrayLike, weights: ArrayLike, camera: Camera, huber: float, across: ArrayLike | None
) -> _Task:
    objects, seen = last_axes(points, (-1, 3), "points"), last_axes(uv, (-1, 2), "uv")
    weight = last_axes(weights, (-1,), "weights")
    batch = objects.shape[:-1]
    if poses.ndim != 3 or len(batch) != 2 or {seen.shape[:-1], weight.shape} != {batch} or len(poses) != batch[0]:
        rule = "poses (B, 4, 4), points (B, N, 3), uv (B, N, 2) and weights (B, N) must agree in B and N"
        raise GeometryError(f"{rule}, not {poses.shape}, {objects.shape}, {seen.shape}, {weight.shape}")
    if not (np.isfinite(weight).all() and (weight >= 0).all()):
        raise GeometryError("weights must be finite and not negative")
    lines = None if across is None else last_axes(across, (-1, 2), "across")
    if lines is not None and lines.shape != seen.shape:
        raise GeometryError(f"across (B, N, 2) must have the shape of uv, {seen.shape}, not {lines.shape}")
    pixels = camera.to_pixels(camera.normalised(seen))
    known = (weight > 0) & np.isfinite(pixels).all(axis=-1) & np.isfinite(objects).all(axis=-1)
    there = known[..., None]
    return _Task(
        np.where(there, objects, 0.0),
        np.where(there, pixels, 0.0),
        np.where(known, weight, 0.0),
        camera.K[:2],
        huber,
        None if lines is None else _onto(lines),
    )


def _onto(across: Floats) -> Floats:
    """(..., 2, 2) the projection onto unit vectors (..., 2); all of an offset where they are NaN."""
    return np.where(np.isnan(across[..., :1, None]), np.eye(2), across[..., :, None] * across[..., None, :])


class _Seen(NamedTuple):
    """Points of poses before the camera."""

    turned: Floats  # (B, N, 3) m
    placed: Floats  # (B, N, 3) m, turned and moved
    off: Floats  # (B, N, 2) px from their pixels
    inverse_depth: Floats  # (B, N) 1/m, 0 behind the camera


def _seen(poses: Floats, task: _Task) -> _Seen:
    turned = task.points @ np.swapaxes(poses[:, :3, :3], -1, -2)
    placed = turned + poses[:, None, :3, 3]
    inverse_depth = np.where(placed[..., 2] > NEAREST, 1.0 / np.maximum(placed[..., 2], NEAREST), 0.0)
    pixels = (placed[..., :2] * inverse_depth[..., None]) @ task.K[:, :2].T + task.K[:, 2]
    off = pixels - task.pixels
    return _Seen(turned, placed, off if task.onto is None else (task.onto @ off[..., None])[..., 0], inverse_depth)


def _chosen(which: NDArray[np.bool_], those: Floats, others: Floats) -> Floats:
    """Rows of `those` (B, ...) where `which` (B,) is true, else of the others."""
    return np.where(which.reshape(-1, *(1 for _ in those.shape[1:])), those, others)


def _cost(seen: _Seen, task: _Task) -> Floats:
    """Weighted sum (B,) of squares, of Huber's function beyond its bound; inf where a point of weight lies behind."""
    square = (seen.off * seen.off).sum(axis=-1)
    if np.isfinite(task.huber):
        distance = np.sqrt(square)
        square = np.where(distance <= task.huber, square, task.huber * (2 * distance - task.huber))
    behind = ((seen.inverse_depth == 0) & (task.weights > 0)).any(axis=-1)
    return np.where(behind, np.inf, (task.weights * square).sum(axis=-1))


def _rms(poses: Floats, task: _Task) -> Floats:
    total = task.weights.sum(axis=-1)
    plain = _cost(_seen(poses, task), task._replace(huber=np.inf))
    return np.where(total > 0, np.sqrt(plain / np.where(total > 0, total, 1.0)), np.nan)


def _normal_equations(seen: _Seen, task: _Task) -> tuple[Floats, Floats]:
    """J^T W J (B, 6, 6) and J^T W r (B, 6), Huber's weights included."""
    turned, placed, off, s = seen
    weight = task.weights
    if np.isfinite(task.huber):
        weight = weight * np.minimum(1.0, task.huber / np.maximum(np.linalg.norm(off, axis=-1), 1e-12))
    jacobian = _counting(_jacobian(turned, placed, s, task.K), task.onto)
    weighted = np.swapaxes(jacobian * np.repeat(weight, 2, axis=1)[..., None], 1, 2)
    return weighted @ jacobian, (weighted @ off.reshape(len(off), -1, 1))[..., 0]


def _jacobian(turned: Floats, placed: Floats, s: Floats, K: Floats) -> Floats:
    """D pixel / d (w, v), (B, 2 N, 6), of points at `placed` (B, N, 3), of inverse depth `s` (B, N), whose arms to the turn's middle are `turned`."""
    by_point = np.zeros((*s.shape, 2, 3))  # d pixel / d point
    by_point[..., :2] = K[:, :2] * s[..., None, None]
    ideal = placed[..., :2] * s[..., None]
    by_point[..., 2] = -(ideal @ K[:, :2].T) * s[..., None]
    by_turn = _cross(turned[..., None, :], by_point)  # row . (w x p) = w . (p x row)
    return np.concatenate([by_turn, by_point], axis=-1).reshape(len(placed), -1, 6)


def _cross(a: Floats, b: Floats) -> Floats:
    """The product (..., 3) of (..., 3) and (..., 3), as numpy's, without what that does besides."""
    x, y, z, u, v, w = *(a[..., axis] for axis in range(3)), *(b[..., axis] for axis in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def _counting(jacobian: Floats, onto: Floats | None) -> Floats:
    """(B, 2 N, 6) what of it counts."""
    if onto is None:
        return jacobian
    by_point = jacobian.reshape(*onto.shape[:2], 2, 6)
    return np.asarray((onto @ by_point).reshape(jacobian.shape))


def information(at: Floats, centre: Floats, weights: Floats, camera: Camera, across: Floats | None = None) -> Floats:
    """J^T W J (6, 6) of places `at` (N, 3) m, before the camera, in its frame, that turn by w rad about `centre` (3,) and move by v m.

    `weights` (N,) are 1/variance of their pixels, undistorted; `across` (N, 2) as in `refine_poses`.
    """
    onto = None if across is None else _onto(across)[None]
    jacobian = _counting(_jacobian((at - centre)[None], at[None], 1.0 / at[None, :, 2], camera.K[:2]), onto)[0]
    return np.asarray((jacobian * np.repeat(weights, 2)[:, None]).T @ jacobian)


def _solve(hessian: Floats, slope: Floats, damping: Floats) -> Floats:
    """The damped step (B, M), scaled by the diagonal: units of angle and length do not mix."""
    diagonal = np.maximum(np.diagonal(hessian, axis1=1, axis2=2), 1e-12)
    damped = hessian + np.eye(hessian.shape[1]) * (diagonal * damping[:, None] + 1e-12)[:, None, :]
    return np.asarray(-np.linalg.solve(damped, slope[..., None])[..., 0])


def _moved(poses: Floats, step: Floats) -> Floats:
    """The poses (B, 4, 4) after the steps (B, 6)."""
    moved = poses.copy()
    moved[:, :3, :3] = _exponential(step[:, :3]) @ poses[:, :3, :3]
    moved[:, :3, 3] += step[:, 3:]
    return moved


def _exponential(w: Floats) -> Floats:
    """Rotations (B, 3, 3) by the vectors `w` (B, 3) rad (Rodrigues)."""
    angle = np.linalg.norm(w, axis=-1)[:, None, None]
    cross = _cross(np.eye(3), w[:, None, :])
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * cross @ cross
    )


def _covariance(hessian: Floats) -> Floats:
    """The inverse (B, 6, 6), scaled to unit diagonal first; inf on the diagonal and 0 beside it where there is none."""
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(hessian, axis1=1, axis2=2), 1e-300))
    unit = hessian * scale[:, :, None] * scale[:, None, :]
    fixed = np.linalg.eigvalsh(unit)[:, 0] > 1e-10
    inverse = np.linalg.inv(np.where(fixed[:, None, None], unit, np.eye(6)))
    inverse = inverse * scale[:, :, None] * scale[:, None, :]
    return np.where(fixed[:, None, None], inverse, np.diag(np.full(6, np.inf)) if not fixed.all() else 0.0)
