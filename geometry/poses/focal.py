"""The focal length that matched points fit best, the pose being free: Levenberg-Marquardt over both.

A wrong focal length is made up for by another depth, but not wholly: what is nearer is drawn larger. The pose's part of
a step, and the damping, are those of ``geometry.poses.reprojection``.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.camera import Camera
from geometry.poses.reprojection import (
    GENTLE,
    STRONG,
    Seen,
    Task,
    cost_of,
    damped_step,
    jacobian_of,
    moved_by,
    reprojected,
    task_of,
)

ROUNDS = 200
"""Steps at most; from a pose of the search some five, from clicks some thirty."""
SETTLED = 1e-10
"""A step is the last whose largest number is below this."""
FREE = 7
"""Numbers that are fitted."""
HALVINGS = 3
"""How often the places are cut in half to be left out by groups: 2³ groups."""
CLICK = 0.5
"""Least standard deviation of a place in the image, px, whatever the residuals say."""


class FocalFit(NamedTuple):
    """``log``: of what the camera's focal length is to be multiplied by; ``pose`` (4, 4), camera_from_object.

    ``noise``: px, as the residuals tell it, at least ``CLICK``; ``error``: the standard error of ``log`` for each px of
    noise, inf where the points fix no focal length.
    """

    log: float
    pose: Floats
    noise: float
    error: float


def focal_fit(points: Floats, uv: Floats, camera: Camera, pose: Floats) -> FocalFit:
    """What ``points`` (N, 3) m, object frame, at the pixels ``uv`` (N, 2) tell, from a ``pose`` that is near."""
    poses, log, damping = pose[None], 0.0, np.full(1, GENTLE)
    task = task_of(poses, points[None], uv[None], np.ones((1, len(points))), camera, np.inf, None)
    here = reprojected(poses, task)
    for _ in range(ROUNDS):
        jacobian = _jacobian(here, _scaled(task, log))
        turned = np.swapaxes(jacobian, 1, 2)
        step = damped_step(turned @ jacobian, (turned @ here.off.reshape(1, -1, 1))[..., 0], damping)
        trial = moved_by(poses, step[:, 1:])
        there = reprojected(trial, _scaled(task, log + step[0, 0]))
        if cost_of(there, task)[0] < cost_of(here, task)[0]:
            poses, log, here, damping = trial, log + float(step[0, 0]), there, damping * 0.2
        else:
            damping = damping * 10.0
        if damping[0] > STRONG or np.abs(step).max() < SETTLED:
            break
    noise = float(np.sqrt(cost_of(here, task)[0] / max(2 * len(points) - FREE, 1)))
    return FocalFit(log, poses[0], max(noise, CLICK), _error(_jacobian(here, _scaled(task, log))[0]))


def error_by_groups(points: Floats, uv: Floats, camera: Camera, fit: FocalFit) -> float:
    """The standard error of a fit's ``log``, by the jackknife over groups of places that are near in the image.

    What is off by about the same at neighbours, as a mesh that is not quite the object's shape or print that lies a
    little aside, is not averaged out by more points there, and residuals do not tell it. Args as of ``focal_fit``.
    """
    groups = [np.arange(len(uv))]
    for _ in range(HALVINGS):
        groups = [half for group in groups for half in _halves(group, uv) if len(half)]
    logs = [focal_fit(np.delete(points, group, 0), np.delete(uv, group, 0), camera, fit.pose).log for group in groups]
    return float(np.sqrt((len(logs) - 1) * np.var(logs)))


def _halves(group: Ints, uv: Floats) -> tuple[Ints, Ints]:
    """A group of indices, cut at the median of the axis along which it is longer."""
    places = uv[group]
    order = np.argsort(places[:, np.argmax(np.ptp(places, axis=0))], kind="stable")
    return group[order[: len(order) // 2]], group[order[len(order) // 2 :]]


def _scaled(task: Task, log: float) -> Task:
    """The task of a camera whose focal lengths are so much longer."""
    K = task.K.copy()
    K[:, :2] *= np.exp(log)
    return task._replace(K=K)


def _jacobian(seen: Seen, task: Task) -> Floats:
    """D pixel / d (ln f, w, v), (1, 2 N, 7)."""
    by_focal = (seen.placed[..., :2] * seen.inverse_depth[..., None]) @ task.K[:, :2].T
    by_pose = jacobian_of(seen.turned, seen.placed, seen.inverse_depth, task.K)
    return np.concatenate([by_focal.reshape(1, -1, 1), by_pose], axis=2)


def _error(jacobian: Floats) -> float:
    """The standard error of ln f, a pixel's noise being 1."""
    size = np.linalg.norm(jacobian, axis=0)
    if not (len(jacobian) >= FREE and size.all() and np.isfinite(jacobian).all()):
        return np.inf
    _, values, right = np.linalg.svd(jacobian / size, full_matrices=False)
    if values[-1] <= 1e-6 * values[0]:
        return np.inf
    return float(np.sqrt(((right[:, 0] / values) ** 2).sum()) / size[0])
