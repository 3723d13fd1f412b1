"""POSIT for coplanar points: two poses explain a flat set nearly equally well, and both are followed.

Source: Oberkampf, DeMenthon and Davis 1996 (formalism §6.1). The image axes are known in the plane only; their
parts along its normal follow from |I| = |J| and I . J = 0 up to one sign, which is the branch.
"""

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Mask, last_axes
from geometry.poses.posit import checked_sets, pose_of, reprojection, turned

FLAT = 1e-3  # least over greatest singular value up to which a set counts as coplanar
THIN = 0.02  # second over greatest singular value below which it counts as collinear


def posit_planar(points: ArrayLike, xy: ArrayLike, *, iterations: int = 40) -> tuple[Floats, Mask]:
    """Both poses of B flat sets: `points` (B, N >= 4, 3) m in the object's frame, seen at `xy` (B, N, 2) = x/z, y/z.

    Returns:
        `camera_from_object` (B, 2, 4, 4), the better reprojection first, and ok (B, 2). Not ok are sets that are not
        finite, not coplanar or nearly collinear, and branches that put a point behind the camera.

    Raises:
        GeometryError: where the shapes do not fit.
    """
    objects, seen = checked_sets(points, xy, fewest=4)
    finite: Mask = np.asarray(np.isfinite(objects).all(axis=(1, 2)) & np.isfinite(seen).all(axis=(1, 2)))
    objects, seen = np.where(finite[:, None, None], objects, 0.0), np.where(finite[:, None, None], seen, 0.0)
    arms = objects - objects[:, :1]
    solver, normal, flat = _plane(arms)
    poses = np.stack([_branch(objects, arms, seen, solver, normal, sign, iterations) for sign in (1.0, -1.0)], axis=1)
    residual = reprojection(poses, objects[:, None], seen[:, None])
    order = np.argsort(residual, axis=1, kind="stable")
    residual = np.take_along_axis(residual, order, axis=1)
    return np.take_along_axis(poses, order[..., None, None], axis=1), (finite & flat)[:, None] & np.isfinite(residual)


def _branch(
    objects: Floats, arms: Floats, seen: Floats, solver: Floats, normal: Floats, sign: float, iterations: int
) -> Floats:
    """One pose (B, 4, 4) a set: the branch `sign` at the start, from then on the one nearer to the last rotation."""
    rotation, depth = _two_poses(solver @ (seen - seen[:, :1]), normal, np.full(len(arms), sign))
    for _ in range(iterations):
        correction = np.clip(np.einsum("bni,bi->bn", arms, rotation[:, 2]) / depth[:, None], -0.95, 20.0)
        axes = solver @ (seen * (1.0 + correction[..., None]) - seen[:, :1])
        options = [_two_poses(axes, normal, np.full(len(arms), side)) for side in (1.0, -1.0)]
        near = [np.einsum("bij,bij->b", option, rotation) for option, _ in options]
        first = near[0] >= near[1]
        rotation = np.where(first[:, None, None], options[0][0], options[1][0])
        depth = np.where(first, options[0][1], options[1][1])
    return pose_of(rotation, depth, objects[:, 0], seen[:, 0])


def _two_poses(axes: Floats, normal: Floats, sign: Floats) -> tuple[Floats, Floats]:
    """Rotation (B, 3, 3) and depth (B,) from the image axes `axes` (B, 3, 2) in the plane and the branch `sign` (B,).

    With I = I0 + a n and J = J0 + b n: (a + ib)^2 = |J0|^2 - |I0|^2 - 2i I0.J0.
    """
    i, j = axes[..., 0], axes[..., 1]
    square = (j * j).sum(-1) - (i * i).sum(-1) - 2j * (i * j).sum(-1)
    root = sign * np.sqrt(square)
    rotation, depth, _ = turned(i + root.real[:, None] * normal, j + root.imag[:, None] * normal)
    return rotation, depth


def _plane(arms: Floats) -> tuple[Floats, Floats, Mask]:
    """Rank-2 pseudo-inverse (B, 3, N), unit normal (B, 3), whether `arms` (B, N, 3) span one plane and no less (B,)."""
    u, s, vt = np.linalg.svd(last_axes(arms, (-1, 3), "arms"), full_matrices=False)
    flat = (s[:, 2] <= FLAT * s[:, 0]) & (s[:, 1] > THIN * s[:, 0])
    keep = np.where(s[:, :2] > 0, 1.0 / np.where(s[:, :2] > 0, s[:, :2], 1.0), 0.0)
    return np.einsum("bki,bk,bnk->bin", vt[:, :2], keep, u[..., :2]), vt[:, 2], flat
