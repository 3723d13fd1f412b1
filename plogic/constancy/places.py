"""Where tracks triangulate to: the most likely place of each, its covariance, and how well it fits.

Vocabulary: ``Places``, of T tracks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.constancy.sights import Sights

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

STEPS = 4
"""Steps of Gauss-Newton from the linear solution."""
NEAREST = 0.01
"""m; depth below which a place is not in front of a camera."""


class Places(NamedTuple):
    """``at`` (T, 3) m, world; ``covariance`` (T, 3, 3) m²; ``chi2`` (T,) of the residuals; ``depth`` (T, V) m.

    ``parallax`` (T,) rad, the greatest between two of the track's lines of sight; ``good`` (T,): solved, and in front of all its views.
    """

    at: Floats
    covariance: Floats
    chi2: Floats
    depth: Floats
    parallax: Floats
    good: NDArray[np.bool_]

    def some(self, which: NDArray[np.bool_] | Ints) -> Places:
        """Those of an index or a mask."""
        parts = (self.at[which], self.covariance[which], self.chi2[which], self.depth[which], self.parallax[which])
        return Places(*parts, self.good[which])


def places_of(sights: Sights, tracks: Ints, kind: Ints) -> Places:
    """The places of ``tracks`` (T, V) of appearance types ``kind`` (T,), two data each at least, by least squares on the images."""
    mask = tracks >= 0
    seen = np.nan_to_num(sights.seen(tracks))
    weight = mask / sights.sigma[:, kind].T  # (T, V)
    at = _linear(sights, seen, mask)
    for _ in range(STEPS):
        residual, jacobian, _ = _residuals(sights, at, seen, weight)
        normal = np.einsum("tvki,tvkj->tij", jacobian, jacobian)
        at = at - _solved(normal, np.einsum("tvki,tvk->ti", jacobian, residual))
    residual, jacobian, depth = _residuals(sights, at, seen, weight)
    normal = np.einsum("tvki,tvkj->tij", jacobian, jacobian)
    good = np.isfinite(at).all(axis=1) & (np.where(mask, depth, np.inf) > NEAREST).all(axis=1) & (np.linalg.cond(normal) < WORST)
    covariance = np.linalg.inv(np.where(good[:, None, None], normal, np.eye(3)))
    return Places(at, covariance, (residual**2).sum(axis=(1, 2)), depth, _parallax(sights, at, mask), good)


WORST = 1e14
"""Condition number of the normal equations beyond which a place is not determined."""


def _linear(sights: Sights, seen: Floats, mask: NDArray[np.bool_]) -> Floats:
    """(T, 3) the points nearest to the lines of sight."""
    rays = np.concatenate([seen, np.ones((*seen.shape[:2], 1))], axis=-1)
    rays = np.einsum("vij,tvi->tvj", sights.camera_from_world[:, :3, :3], rays)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    across = (np.eye(3) - rays[..., :, None] * rays[..., None, :]) * mask[..., None, None]
    return _solved(across.sum(axis=1), np.einsum("tvij,vj->ti", across, sights.eye))


def _solved(matrix: Floats, right: Floats) -> Floats:
    """(T, 3) the solutions; a hair on the diagonal keeps singular systems finite, ``good`` tells them later."""
    size = np.trace(matrix, axis1=1, axis2=2)[:, None, None]
    solution = np.linalg.solve(matrix + np.eye(3) * (1e-12 * size + 1e-30), right[..., None])
    return np.asarray(solution[..., 0])


def _residuals(sights: Sights, at: Floats, seen: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Residuals (T, V, 2) in standard deviations, their derivatives by the place (T, V, 2, 3), depths (T, V)."""
    R, t = sights.camera_from_world[:, :3, :3], sights.camera_from_world[:, :3, 3]
    points = np.einsum("vij,tj->tvi", R, at) + t
    z = points[..., 2]
    safe = np.where(np.abs(z) > NEAREST, z, NEAREST)
    ideal = points[..., :2] / safe[..., None]
    jacobian = (R[None, :, :2] - ideal[..., None] * R[None, :, 2:]) / safe[..., None, None]
    return (ideal - seen) * weight[..., None], jacobian * weight[..., None, None], z


def _parallax(sights: Sights, at: Floats, mask: NDArray[np.bool_]) -> Floats:
    sight = at[:, None] - sights.eye
    sight /= np.maximum(np.linalg.norm(sight, axis=-1, keepdims=True), 1e-12)
    cosine = np.einsum("tvi,twi->tvw", sight, sight)
    both = mask[:, :, None] & mask[:, None, :]
    return np.arccos(np.clip(np.where(both, cosine, 1.0).min(axis=(1, 2)), -1.0, 1.0))
