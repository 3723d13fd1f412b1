"""How far an object's points reproject from their pixels, and the step that brings them nearer.

What refinements of poses are made of.

A step (w, v) turns the object by exp(w) about its own origin, in the camera's axes, and moves that origin by v. The
residuals are undistorted pixels, so that the Jacobian is that of a pinhole, whatever the lens.

* ``Task``: what is to be met, of a batch of poses; ``Seen``: the points of poses before the camera

What the angle of a feature on the screen says of a pose: the way to a point along the x axis of its frame must lie on
the datum's line.

* ``ends(points, axes, depth, length)``: those points, in any frame; ``across(angle)``: unit vectors across the lines

What places on the screen say of a pose: J^T W J, of one pose or of a batch.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import Floats, last_axes, lengths, summed
from geometry.camera import NEAREST, Camera
from geometry.errors import GeometryError

ARM = 2.0
"""The point is so far away, on the screen, that the noise of the angle moves it by so many times the noise of a
place."""
WEIGHT = 1.0 / (1.0 + ARM**2)
"""How much it weighs beside a place: its own place is off by the noise of the feature's and, ``ARM`` times as far, by
that of the angle."""


GENTLE, STRONG = 1e-4, 1e8  # damping at the start, and at its most


class Task(NamedTuple):
    """Points of a batch of B objects, and where they should be."""

    points: Floats  # (B, N, 3) m, object frame
    pixels: Floats  # (B, N, 2) undistorted px
    weights: Floats  # (B, N), 0 for a missing point
    K: Floats  # (2, 3)
    huber: float  # px
    onto: Floats | None  # (B, N, 2, 2), what of an offset counts


def task_of(
    poses: Floats,
    points: ArrayLike,
    uv: ArrayLike,
    weights: ArrayLike,
    camera: Camera,
    huber: float,
    across: ArrayLike | None,
) -> Task:
    """The task of `refine_poses`.

    Raises GeometryError where the shapes do not fit, or a weight is negative or not finite.
    """
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
    return Task(
        np.where(there, objects, 0.0),
        np.where(there, pixels, 0.0),
        np.where(known, weight, 0.0),
        camera.K[:2],
        huber,
        None if lines is None else onto_lines(lines),
    )


def onto_lines(across: Floats) -> Floats:
    """(..., 2, 2) the projection onto unit vectors (..., 2); all of an offset where they are NaN."""
    return np.where(np.isnan(across[..., :1, None]), np.eye(2), across[..., :, None] * across[..., None, :])


class Seen(NamedTuple):
    """Points of poses before the camera."""

    turned: Floats  # (B, N, 3) m
    placed: Floats  # (B, N, 3) m, turned and moved
    off: Floats  # (B, N, 2) px from their pixels
    inverse_depth: Floats  # (B, N) 1/m, 0 behind the camera


def reprojected(poses: Floats, task: Task) -> Seen:
    """The points of the poses (B, 4, 4)."""
    turned = task.points @ np.swapaxes(poses[:, :3, :3], -1, -2)
    placed = turned + poses[:, None, :3, 3]
    inverse_depth = np.where(placed[..., 2] > NEAREST, 1.0 / np.maximum(placed[..., 2], NEAREST), 0.0)
    pixels = (placed[..., :2] * inverse_depth[..., None]) @ task.K[:, :2].T + task.K[:, 2]
    off = pixels - task.pixels
    return Seen(turned, placed, off if task.onto is None else (task.onto @ off[..., None])[..., 0], inverse_depth)


def chosen_of(which: NDArray[np.bool_], those: Floats, others: Floats) -> Floats:
    """Rows of `those` (B, ...) where `which` (B,) is true, else of the others."""
    return np.where(which.reshape(-1, *(1 for _ in those.shape[1:])), those, others)


def cost_of(seen: Seen, task: Task) -> Floats:
    """Weighted sum (B,) of squares, of Huber's function beyond its bound; inf where a point of weight lies behind."""
    square = summed(seen.off * seen.off)
    if np.isfinite(task.huber):
        distance = np.sqrt(square)
        square = np.where(distance <= task.huber, square, task.huber * (2 * distance - task.huber))
    behind = ((seen.inverse_depth == 0) & (task.weights > 0)).any(axis=-1)
    return np.where(behind, np.inf, (task.weights * square).sum(axis=-1))


def normal_equations(seen: Seen, task: Task) -> tuple[Floats, Floats]:
    """J^T W J (B, 6, 6) and J^T W r (B, 6), Huber's weights included."""
    turned, placed, off, s = seen
    weight = task.weights
    if np.isfinite(task.huber):
        weight = weight * np.minimum(1.0, task.huber / np.maximum(lengths(off), 1e-12))
    jacobian = counting(jacobian_of(turned, placed, s, task.K), task.onto)
    weighted = np.swapaxes(jacobian * np.repeat(weight, 2, axis=1)[..., None], 1, 2)
    return weighted @ jacobian, (weighted @ off.reshape(len(off), -1, 1))[..., 0]


def jacobian_of(turned: Floats, placed: Floats, s: Floats, K: Floats) -> Floats:
    """D pixel / d (w, v), (B, 2 N, 6), of points at `placed` (B, N, 3), of inverse depth `s` (B, N).

    `turned` are their arms to the turn's middle.
    """
    both = np.empty((*s.shape, 2, 6))
    by_point = both[..., 3:]  # d pixel / d point
    by_point[..., :2] = K[:, :2] * s[..., None, None]
    ideal = placed[..., :2] * s[..., None]
    by_point[..., 2] = -(ideal @ K[:, :2].T) * s[..., None]
    _cross(turned[..., None, :], by_point, both[..., :3])  # row . (w x p) = w . (p x row)
    return both.reshape(len(placed), -1, 6)


def _cross(a: Floats, b: Floats, out: Floats | None = None) -> Floats:
    """The product (..., 3) of (..., 3) and (..., 3), as numpy's, without what that does besides."""
    x, y, z, u, v, w = *(a[..., axis] for axis in range(3)), *(b[..., axis] for axis in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1, out=out)


def counting(jacobian: Floats, onto: Floats | None) -> Floats:
    """(B, 2 N, 6) what of it counts."""
    if onto is None:
        return jacobian
    by_point = jacobian.reshape(*onto.shape[:2], 2, 6)
    return np.asarray((onto @ by_point).reshape(jacobian.shape))


def damped_step(hessian: Floats, slope: Floats, damping: Floats) -> Floats:
    """The damped step (B, M), scaled by the diagonal: units of angle and length do not mix."""
    diagonal = np.maximum(np.diagonal(hessian, axis1=1, axis2=2), 1e-12)
    damped = hessian + np.eye(hessian.shape[1]) * (diagonal * damping[:, None] + 1e-12)[:, None, :]
    return np.asarray(-np.linalg.solve(damped, slope[..., None])[..., 0])


def moved_by(poses: Floats, step: Floats) -> Floats:
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


def reach(pixels: Floats, angle: float) -> Floats:
    """(...,) how far away the point is, pixels, at a noise of places ``pixels`` (...,), and of angles, radians."""
    return ARM * pixels / angle


def ends(points: Floats, axes: Floats, depth: Floats, length: Floats) -> Floats:
    """(..., 3) m, the points along unit ``axes`` (..., 3) from ``points`` (..., 3), in the frame of both.

    ``depth`` (...,) m of the points before the camera; ``length`` (...,) pixels over the focal length.
    """
    return points + (length * np.maximum(depth, 0.0))[..., None] * axes


def across(angle: Floats) -> Floats:
    """(..., 2) unit vectors across lines at angles (...,), radians clockwise on the screen."""
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)


def information(at: Floats, centre: Floats, weights: Floats, camera: Camera, across: Floats | None = None) -> Floats:
    """J^T W J (..., 6, 6) of places `at` (..., N, 3) m in the camera's frame.

    They turn by w rad about `centre` (..., 3) and move by v m.

    `weights` (..., N) are 1/variance of their pixels, undistorted; `across` (..., N, 2) as in
    `geometry.poses.refine.refine_poses`.
    """
    batch = at.shape[:-2]
    placed = at.reshape(int(np.prod(batch)), *at.shape[-2:])
    turned = (at - centre[..., None, :]).reshape(placed.shape)
    onto = None if across is None else onto_lines(across).reshape(*placed.shape[:2], 2, 2)
    jacobian = counting(jacobian_of(turned, placed, 1.0 / placed[..., 2], camera.K[:2]), onto)
    weighted = jacobian * np.repeat(weights.reshape(placed.shape[:2]), 2, axis=1)[..., None]
    return np.asarray((np.swapaxes(weighted, 1, 2) @ jacobian).reshape(*batch, 6, 6))
