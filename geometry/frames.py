"""Rigid frames as 4x4 matrices named by what they map: `camera_from_object` takes object to camera coordinates.

A product is right when neighbours cancel: `camera_from_object = camera_from_world @ world_from_object`.
Every function broadcasts over leading axes; positions are metres, angles radians, quaternions in the order x, y, z, w.
"""

import math
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, last_axes
from geometry.errors import GeometryError


def from_rotation_translation(R: ArrayLike, t: ArrayLike) -> Floats:
    """The transform (..., 4, 4) that rotates by `R` (..., 3, 3) and then moves by `t` (..., 3)."""
    rotation, translation = last_axes(R, (3, 3), "R"), last_axes(t, (3,), "t")
    leading = np.broadcast_shapes(rotation.shape[:-2], translation.shape[:-1])
    transform = np.zeros((*leading, 4, 4))
    transform[..., :3, :3] = rotation
    transform[..., :3, 3] = translation
    transform[..., 3, 3] = 1.0
    return transform


def inverse(T: ArrayLike) -> Floats:
    """`b_from_a` of the rigid `a_from_b` (..., 4, 4), by transposition of its rotation."""
    transform = last_axes(T, (4, 4), "T")
    back = np.swapaxes(transform[..., :3, :3], -1, -2)
    return from_rotation_translation(back, -np.einsum("...ij,...j->...i", back, transform[..., :3, 3]))


def compose(*transforms: ArrayLike) -> Floats:
    """`a_from_b, b_from_c, ... -> a_from_z`: the product in the order given; the identity for no argument."""
    return reduce(np.matmul, (last_axes(T, (4, 4), "T") for T in transforms), np.eye(4))


def transform_points(T: ArrayLike, points: ArrayLike) -> Floats:
    """`points` (..., N, 3) of frame b in frame a, for `T` = `a_from_b` (..., 4, 4); (..., N, 3)."""
    transform, positions = last_axes(T, (4, 4), "T"), last_axes(points, (-1, 3), "points")
    return np.asarray(positions @ np.swapaxes(transform[..., :3, :3], -1, -2) + transform[..., None, :3, 3])


def rotate(T: ArrayLike, directions: ArrayLike) -> Floats:
    """`directions` (..., N, 3) of frame b in frame a: turned by `T` = `a_from_b` (..., 4, 4), not moved."""
    transform, arrows = last_axes(T, (4, 4), "T"), last_axes(directions, (-1, 3), "directions")
    return np.asarray(arrows @ np.swapaxes(transform[..., :3, :3], -1, -2))


def is_rigid(T: ArrayLike, tolerance: float = 1e-6) -> bool:
    """Whether the 4x4 `T` is finite, right-handed, orthonormal within `tolerance`, and ends in the row 0 0 0 1."""
    transform = np.asarray(T, dtype=np.float64)
    if transform.shape != (4, 4) or not np.isfinite(transform).all():
        return False
    R = transform[:3, :3]
    straight = bool(np.abs(R @ R.T - np.eye(3)).max() <= tolerance)
    return straight and bool(np.linalg.det(R) > 0) and bool(np.abs(transform[3] - [0, 0, 0, 1]).max() <= tolerance)


def rotation_angle(R: ArrayLike) -> Floats:
    """The angle (...) in [0, pi] rad of each rotation `R` (..., 3, 3); exact near 0 and near pi alike."""
    rotation = last_axes(R, (3, 3), "R")
    twist = np.stack([rotation[..., i, j] - rotation[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
    trace = np.trace(rotation, axis1=-2, axis2=-1)
    return np.asarray(np.arctan2(np.linalg.norm(twist, axis=-1), trace - 1.0))


def pose_error(
    camera_from_a: ArrayLike, camera_from_b: ArrayLike, symmetries: ArrayLike | None = None
) -> tuple[Floats, Floats]:
    """How far two poses (..., 4, 4) of one object are apart: (rotation rad (...), translation of the origin m (...)).

    `symmetries` (S, 4, 4) are the object's own motions that change nothing (the identity counts always): the one that
    leaves the smallest rotation, and among equals the smallest translation, is taken.
    """
    a, b = last_axes(camera_from_a, (4, 4), "camera_from_a"), last_axes(camera_from_b, (4, 4), "camera_from_b")
    own = (
        np.eye(4)[None]
        if symmetries is None
        else np.concatenate([np.eye(4)[None], last_axes(symmetries, (-1, 4, 4), "symmetries")])
    )
    turned = a[..., None, :, :] @ own
    target = np.broadcast_to(b[..., None, :, :], np.broadcast_shapes(turned.shape, b[..., None, :, :].shape))
    rotations = rotation_angle(np.swapaxes(turned[..., :3, :3], -1, -2) @ target[..., :3, :3])
    moves = np.linalg.norm(turned[..., :3, 3] - target[..., :3, 3], axis=-1)
    best = np.lexsort((moves, np.round(rotations, 9)), axis=-1)[..., :1]
    return np.take_along_axis(rotations, best, -1)[..., 0], np.take_along_axis(moves, best, -1)[..., 0]


def rotation_from_quat_xyzw(quat_xyzw: ArrayLike) -> Floats:
    """Rotations (..., 3, 3) of quaternions (..., 4) in the order x, y, z, w; the length need not be 1, but not 0."""
    quaternion = last_axes(quat_xyzw, (4,), "quat_xyzw")
    length = np.linalg.norm(quaternion, axis=-1, keepdims=True)
    if not (np.isfinite(length).all() and (length > 0).all()):
        raise GeometryError(f"quat_xyzw must be finite and not zero, not {quaternion.tolist()}")
    rows = np.array(_turned(*np.moveaxis(quaternion / length, -1, 0)))
    return np.ascontiguousarray(np.moveaxis(rows, (0, 1), (-2, -1)))


def _turned(x: Any, y: Any, z: Any, w: Any) -> list[list[Any]]:  # noqa: ANN401 - numbers, or arrays (...) of them
    """The rows of the rotation of a unit quaternion."""
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def turn_about(axis: ArrayLike, angle: float) -> Floats:
    """The rotation (3, 3) by `angle` rad about the unit vector `axis` (3,)."""
    x, y, z = (math.sin(angle / 2) * float(part) for part in np.asarray(axis))
    w = math.cos(angle / 2)
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return np.array(_turned(x / length, y / length, z / length, w / length))


def least_turns(start: ArrayLike, end: ArrayLike) -> Floats:
    """(..., 3, 3) the least rotations of unit vectors `start` (..., 3) to `end` (..., 3), which are not opposite."""
    start, end = last_axes(start, (3,), "start"), last_axes(end, (3,), "end")
    across = np.cross(np.eye(3), np.cross(start, end)[..., None, :])
    return np.asarray(np.eye(3) + across + across @ across / (1.0 + (start * end).sum(axis=-1))[..., None, None])


def motion_about(axis: ArrayLike, at: ArrayLike, angle: float) -> Floats:
    """The motion (4, 4) that turns by `angle` rad about the line through `at` (3,) along a unit `axis` (3,)."""
    turn = turn_about(axis, angle)
    return from_rotation_translation(turn, np.asarray(at) - turn @ np.asarray(at))


def quat_xyzw_from_rotation(R: ArrayLike) -> Floats:
    """Unit quaternions (..., 4), x, y, z, w with w >= 0, of rotations `R` (..., 3, 3).

    Of the four columns of q qT, which are the same quaternion four times, the longest is taken: no cancellation.
    """
    m = last_axes(R, (3, 3), "R")
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    xy, xz, yz = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    xw, yw, zw = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    outer = np.stack(
        [
            np.stack([1 + xx - yy - zz, xy, xz, xw], axis=-1),
            np.stack([xy, 1 - xx + yy - zz, yz, yw], axis=-1),
            np.stack([xz, yz, 1 - xx - yy + zz, zw], axis=-1),
            np.stack([xw, yw, zw, 1 + xx + yy + zz], axis=-1),
        ],
        axis=-2,
    )
    longest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(outer, longest[..., None, None], axis=-2)[..., 0, :]
    quaternion = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return np.asarray(np.where(quaternion[..., 3:] < 0, -quaternion, quaternion))


def look_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> Floats:
    """`camera_from_world` (4, 4) of a camera at `eye` (3,) m looking at `target` (3,) m, `up` (3,) upward in the image.

    Raises:
        GeometryError: where `eye` is `target`, or `up` lies along the line of sight.
    """
    position = last_axes(eye, (3,), "eye")
    forward = last_axes(target, (3,), "target") - position
    right = np.cross(forward, last_axes(up, (3,), "up"))
    if not np.linalg.norm(right) > 1e-9 * np.linalg.norm(forward):
        raise GeometryError(f"look_at: up {up!r} must not lie along the line of sight from {eye!r} to {target!r}")
    z, x = forward / np.linalg.norm(forward), right / np.linalg.norm(right)
    world_from_camera = from_rotation_translation(np.stack([x, np.cross(z, x), z], axis=-1), position)
    return inverse(world_from_camera)
