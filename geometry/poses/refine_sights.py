"""One pose from what several cameras of known places see: least squares in the world's axes (a moving camera, a stereo pair).

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
    Task,
    cost_of,
    damped_step,
    moved_by,
    normal_equations,
    reprojected,
    task_of,
)


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
