"""POSIT: a pose from four or more matched, non-coplanar points, for thousands of sets at once.

Source: DeMenthon and Davis 1995 (formalism §6.1), with the reference point (the first of each set) subtracted.
Scaled-orthographic start; each round corrects the image points for perspective with the depths of the last one.

Four points at 0.5 px noise are often worthless (90th percentile of the rotation error: 76 degrees), for the sets are
nearly flat as seen. To first order the rotation is wrong by (image noise) x Z / (least singular value of the points):
that factor is the set's `condition`, and a set that `noise` would turn by more than `max_turn` is refused. Even a good
pose wants `geometry.poses.refine` on all inliers afterwards; a wrong match may converge too: judge by evidence.

POSIT for coplanar points: two poses explain a flat set nearly equally well, and both are followed.

Source: Oberkampf, DeMenthon and Davis 1996 (formalism §6.1). The image axes are known in the plane only; their
parts along its normal follow from |I| = |J| and I . J = 0 up to one sign, which is the branch.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Mask, last_axes, lengths, summed
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation

FEWEST = 4  # points of a set
THIN = 0.02  # second over greatest singular value below which it counts as collinear


NOISE = 0.5 / 600  # image noise that a pose has to bear: 0.5 px at f = 600 px, in normalised units
MAX_TURN = 0.15  # rad; the expected turn by that noise beyond which a set is refused
FLAT = 1e-3  # least over greatest singular value below which a set counts as coplanar
SETTLED = 1e-4  # the last change of the perspective correction (a part of the depth) at which a pose has settled
SKEW = 0.35  # how unlike in length, and how far from perpendicular (as a cosine), the two image axes may come out


@dataclass(frozen=True, eq=False)
class PositResult:
    """Poses of a batch: where `ok` is False the pose is finite but means nothing."""

    camera_from_object: Floats  # (B, 4, 4)
    ok: Mask  # (B,)
    condition: Floats  # (B,) rad of rotation per unit of normalised image noise; inf for coplanar sets
    residual: Floats  # (B,) rms distance of reprojection, normalised units; inf where a point lies behind the camera


def posit(
    points: ArrayLike,
    xy: ArrayLike,
    *,
    noise: float = NOISE,
    max_turn: float = MAX_TURN,
    iterations: int = 30,
) -> PositResult:
    """Poses of B sets: `points` (B, N >= 4, 3) m in the object's frame, seen at `xy` (B, N, 2) = x/z, y/z.

    Not ok are sets that are coplanar, ill-conditioned for `noise`, not finite, behind the camera, whose two image axes
    are grossly unlike (no pose fits them), or that do not settle within `iterations`.

    Raises:
        GeometryError: where the shapes do not fit.
    """
    objects, seen, finite = checked_sets(points, xy)
    arms = objects - objects[:, :1]
    solver, least = _pseudo_inverse(arms)
    rotation, depth, skew, settled = _iterate(arms, seen, solver, iterations)
    poses = pose_of(rotation, depth, objects[:, 0], seen[:, 0])
    residual = reprojection(poses, objects, seen)
    condition = np.divide(depth, least, out=np.full(len(depth), np.inf), where=least > 0)
    steady = condition * noise <= max_turn
    return PositResult(poses, finite & settled & steady & (skew < SKEW) & np.isfinite(residual), condition, residual)


def checked_sets(points: ArrayLike, xy: ArrayLike) -> tuple[Floats, Floats, Mask]:
    """`points` (B, N >= 4, 3), `xy` (B, N, 2), and which sets are finite (B,); those that are not become 0.

    Raises:
        GeometryError: where the shapes do not fit.
    """
    objects, seen = last_axes(points, (-1, 3), "points"), last_axes(xy, (-1, 2), "xy")
    if objects.ndim != 3 or objects.shape[:2] != seen.shape[:2] or objects.shape[1] < FEWEST:
        rule = f"points (B, N, 3) and xy (B, N, 2) must agree in B and in N >= {FEWEST}"
        raise GeometryError(f"{rule}, not {objects.shape} and {seen.shape}")
    finite: Mask = np.asarray(np.isfinite(objects).all(axis=(1, 2)) & np.isfinite(seen).all(axis=(1, 2)))
    return np.where(finite[:, None, None], objects, 0.0), np.where(finite[:, None, None], seen, 0.0), finite


def pose_of(rotation: Floats, depth: Floats, reference: Floats, seen: Floats) -> Floats:
    """`camera_from_object` (..., 4, 4) with the point `reference` (..., 3) at `depth` (...,) on `seen` (..., 2)."""
    place = np.concatenate([seen, np.ones((*seen.shape[:-1], 1))], axis=-1) * depth[..., None]
    return from_rotation_translation(rotation, place - np.einsum("...ij,...j->...i", rotation, reference))


def reprojection(poses: Floats, objects: Floats, seen: Floats) -> Floats:
    """Rms distance (...,) of the reprojected `objects` (..., N, 3) from `seen` (..., N, 2); inf where one is behind."""
    placed = objects @ np.swapaxes(poses[..., :3, :3], -1, -2) + poses[..., None, :3, 3]
    front = np.asarray((placed[..., 2] > 0).all(axis=-1))
    z = np.where(front[..., None], placed[..., 2], 1.0)
    off = placed[..., :2] / z[..., None] - seen
    return np.where(front, np.sqrt(summed(off**2).mean(axis=-1)), np.inf)


def turned(i: Floats, j: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotation (..., 3, 3), depth (...,) and skew (...,) of the image axes `i`, `j` (..., 3), of length about 1/depth.

    The error is shared between the two axes. Skew is the greater of |cos| between them and their unlikeness in length.
    """
    length_i, length_j = (np.maximum(lengths(axis), 1e-12) for axis in (i, j))
    a, b = i / length_i[..., None], j / length_j[..., None]
    middle, across = _unit(a + b), _unit(a - b)  # perpendicular, whatever the angle between the two
    x, y = _unit(middle + across), _unit(middle - across)
    skew = np.maximum(np.abs(summed(a * b)), np.abs(np.log(length_i / length_j)))
    return np.stack([x, y, np.cross(x, y)], axis=-2), 1.0 / np.sqrt(length_i * length_j), skew


def _iterate(arms: Floats, seen: Floats, solver: Floats, iterations: int) -> tuple[Floats, Floats, Floats, Mask]:
    """Rotation (B, 3, 3), depth (B,) of the reference, skew (B,), and whether the correction settled (B,)."""
    correction = np.zeros(arms.shape[:2])
    for _ in range(iterations):
        image = seen * (1.0 + correction[..., None]) - seen[:, :1]
        axes = solver @ image
        rotation, depth, skew = turned(axes[..., 0], axes[..., 1])
        before, correction = correction, np.einsum("bni,bi->bn", arms, rotation[:, 2]) / depth[:, None]
        change = np.abs(correction - before).max(axis=1)
        correction = np.clip(correction, -0.95, 20.0)  # no point may come to lie behind the camera on the way
        if change.max(initial=0.0) < 1e-10:
            break
    return rotation, depth, skew, np.asarray(change < SETTLED)


def _pseudo_inverse(arms: Floats) -> tuple[Floats, Floats]:
    """Pseudo-inverse (B, 3, N) and least singular value (B,) of `arms` (B, N, 3); coplanar sets have least 0."""
    u, s, vt = np.linalg.svd(arms, full_matrices=False)
    solid = s[:, 2] > FLAT * s[:, 0]
    inverse = np.where(s > FLAT * s[:, :1], 1.0 / np.where(s > 0, s, 1.0), 0.0)
    return np.einsum("bki,bk,bnk->bin", vt, inverse, u), np.where(solid, s[:, 2], 0.0)


def _unit(vectors: Floats) -> Floats:
    length = lengths(vectors)[..., None]
    return np.asarray(vectors / np.maximum(length, 1e-12))


def posit_planar(points: ArrayLike, xy: ArrayLike, *, iterations: int = 40) -> tuple[Floats, Mask]:
    """Both poses of B flat sets: `points` (B, N >= 4, 3) m in the object's frame, seen at `xy` (B, N, 2) = x/z, y/z.

    Returns:
        `camera_from_object` (B, 2, 4, 4), the better reprojection first, and ok (B, 2). Not ok are sets that are not
        finite, not coplanar or nearly collinear, and branches that put a point behind the camera.

    Raises:
        GeometryError: where the shapes do not fit.
    """
    objects, seen, finite = checked_sets(points, xy)
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
