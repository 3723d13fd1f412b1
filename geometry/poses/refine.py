"""Least-squares refinement of poses on all their inliers: Levenberg-Marquardt on SE(3), a batch at once.

What a step is, and what the residuals are: `geometry.poses.reprojection`.

One pose from what several cameras of known places see: least squares in the world's axes (a moving camera, a stereo
pair).

* ``Sight``: what one camera sees of an object
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.camera import Camera
from geometry.poses.reprojection import (
    GENTLE,
    STRONG,
    Seen,
    Task,
    chosen_of,
    cost_of,
    damped_step,
    moved_by,
    normal_equations,
    reprojected,
    task_of,
)


class Steps(NamedTuple):
    """So many at most; where `moves` (6, M) are given each step (w, v) is a combination of its columns."""

    number: int = 8
    moves: ArrayLike | None = None


USUAL = Steps()


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
    task = task_of(poses, points, uv, weights, camera, np.inf if huber is None else huber, across)
    poses = _descended(poses, task, Steps(iterations))
    return poses, _rms(poses, task), _covariance(normal_equations(reprojected(poses, task), task)[0])


def refined_poses(
    camera_from_object: ArrayLike,
    points: ArrayLike,
    uv: ArrayLike,
    weights: ArrayLike,
    camera: Camera,
    steps: Steps = USUAL,
    *,
    huber: float | None = None,
    across: ArrayLike | None = None,
) -> Floats:
    """The poses (B, 4, 4) of `refine_poses` alone, sooner.

    Raises:
        GeometryError: where the shapes do not fit, or a weight is negative or not finite.
    """
    poses = np.array(last_axes(camera_from_object, (4, 4), "camera_from_object"))
    task = task_of(poses, points, uv, weights, camera, np.inf if huber is None else huber, across)
    return _descended(poses, task, steps)


def _descended(poses: Floats, task: Task, steps: Steps) -> Floats:
    """Poses (B, 4, 4) after so many damped steps, those that make them worse left out.

    Raises GeometryError for moves of another shape.
    """
    ways = np.eye(6) if steps.moves is None else last_axes(steps.moves, (6, -1), "moves")
    here, damping = reprojected(poses, task), np.full(len(poses), GENTLE)
    cost = cost_of(here, task)
    for _ in range(steps.number):
        hessian, slope = normal_equations(here, task)
        step = damped_step(ways.T @ hessian @ ways, slope @ ways, damping) @ ways.T
        trial = moved_by(poses, step)
        there = reprojected(trial, task)
        trial_cost = cost_of(there, task)
        better = trial_cost < cost
        poses = np.where(better[:, None, None], trial, poses)
        here = (
            there
            if better.all()
            else Seen(*(chosen_of(better, its, own) for its, own in zip(there, here, strict=True)))
        )
        cost = np.where(better, trial_cost, cost)
        damping = np.where(better, damping * 0.2, np.minimum(damping * 10, STRONG))
        if np.abs(step[better]).max(initial=0.0) < 1e-12:
            break
    return poses


def _rms(poses: Floats, task: Task) -> Floats:
    total = task.weights.sum(axis=-1)
    plain = cost_of(reprojected(poses, task), task._replace(huber=np.inf))
    return np.where(total > 0, np.sqrt(plain / np.where(total > 0, total, 1.0)), np.nan)


def _covariance(hessian: Floats) -> Floats:
    """The inverse (B, 6, 6), scaled to unit diagonal first; inf on the diagonal and 0 beside it where there is none."""
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(hessian, axis1=1, axis2=2), 1e-300))
    unit = hessian * scale[:, :, None] * scale[:, None, :]
    fixed = np.linalg.eigvalsh(unit)[:, 0] > 1e-10
    inverse = np.linalg.inv(np.where(fixed[:, None, None], unit, np.eye(6)))
    inverse = inverse * scale[:, :, None] * scale[:, None, :]
    return np.where(fixed[:, None, None], inverse, np.diag(np.full(6, np.inf)) if not fixed.all() else 0.0)


class Sight(NamedTuple):
    """`points` (N, 3) m of the object, seen at `uv` (N, 2) px with `weights` (N,) 1/px^2.

    `across` (N, 2) as in `refine_poses`.
    """

    camera: Camera
    camera_from_world: Floats
    points: Floats
    uv: Floats
    weights: Floats
    across: Floats | None = None


def refine_sights(
    world_from_object: ArrayLike, sights: Sequence[Sight], iterations: int = 8, *, huber: float | None = None
) -> Floats:
    """The pose (4, 4) in the world that reprojects all sights of one object best, from the one given.

    It gets no worse than it came; without a sight it stays. `huber` (px) makes residuals beyond it count linearly.

    Raises:
        GeometryError: where the shapes do not fit, or a weight is negative or not finite.
    """
    pose = np.array(last_axes(world_from_object, (4, 4), "world_from_object"))
    tasks = [_task(sight, pose, np.inf if huber is None else huber) for sight in sights]
    damping, cost = GENTLE, _cost(pose, sights, tasks)
    for _ in range(iterations if tasks else 0):
        hessian, slope = _equations(pose, sights, tasks)
        step = damped_step(hessian[None], slope[None], np.array([damping]))
        trial = moved_by(pose[None], step)[0]
        trial_cost = _cost(trial, sights, tasks)
        better = trial_cost < cost
        pose, cost = (trial, trial_cost) if better else (pose, cost)
        damping = damping * 0.2 if better else min(damping * 10, STRONG)
        if better and np.abs(step).max() < 1e-12:
            break
    return pose


def turned_step(R: Floats) -> Floats:
    """(6, 6) that turns a step (w, v), of which both are directions, by `R` (3, 3)."""
    return np.asarray(np.kron(np.eye(2), R))


def _task(sight: Sight, pose: Floats, huber: float) -> Task:
    across = None if sight.across is None else sight.across[None]
    return task_of(
        _placed(sight, pose), sight.points[None], sight.uv[None], sight.weights[None], sight.camera, huber, across
    )


def _placed(sight: Sight, pose: Floats) -> Floats:
    """camera_from_object (1, 4, 4)."""
    return np.asarray((sight.camera_from_world @ pose)[None])


def _cost(pose: Floats, sights: Sequence[Sight], tasks: Sequence[Task]) -> float:
    return float(
        sum(cost_of(reprojected(_placed(s, pose), task), task)[0] for s, task in zip(sights, tasks, strict=True))
    )


def _equations(pose: Floats, sights: Sequence[Sight], tasks: Sequence[Task]) -> tuple[Floats, Floats]:
    """J^T W J (6, 6) and J^T W r (6,) of all sights together, of a step (w, v) in the world's axes."""
    hessian, slope = np.zeros((6, 6)), np.zeros(6)
    for sight, task in zip(sights, tasks, strict=True):
        own, down = normal_equations(reprojected(_placed(sight, pose), task), task)
        turn = turned_step(sight.camera_from_world[:3, :3])
        hessian += turn.T @ own[0] @ turn
        slope += down[0] @ turn
    return hessian, slope
