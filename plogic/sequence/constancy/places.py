"""Where tracks triangulate to: the most likely place of each, its covariance, and how well it fits.

Vocabulary: ``Places``, of T tracks. Inside, an *observation* is one datum of one track; there are O of them, those of a
track together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from plogic.sequence.constancy.sight_lines import Sights


STEPS = 3
"""Steps of Gauss-Newton from the linear solution."""
NEAREST = 0.01
"""m; depth below which a place is not in front of a camera."""
WORST = 1e-15
"""Determinant of the normal equations, as a share of the cube of their mean eigenvalue, below which a place is not
determined."""


class Places(NamedTuple):
    """``at`` (T, 3) m, world; ``covariance`` (T, 3, 3) m²; ``chi2`` (T,) of the residuals.

    ``depth`` (T, V) m, NaN in other views.

    ``parallax`` (T,) rad, the greatest between two of the track's lines of sight; ``good`` (T,): solved, and in front
    of all its views.
    """

    at: Floats
    covariance: Floats
    chi2: Floats
    depth: Floats
    parallax: Floats
    good: Mask

    def some(self, which: Mask | Indices) -> Places:
        """Those of an index or a mask."""
        parts = (self.at[which], self.covariance[which], self.chi2[which], self.depth[which], self.parallax[which])
        return Places(*parts, self.good[which])


class _Observed(NamedTuple):
    """``track``, ``view`` (O,); ``first`` (T,) where each track's begin; ``seen`` (O, 2) ideal.

    ``weight`` (O,) one over the noise.
    """

    track: Indices
    view: Indices
    first: Indices
    seen: Floats
    weight: Floats
    R: Floats
    t: Floats

    def total(self, values: Floats) -> Floats:
        """(T, ...) the sums of values (O, ...) over each track."""
        return np.add.reduceat(values, self.first, axis=0)


def places_of(sights: Sights, tracks: Indices, kind: Indices) -> Places:
    """The places of ``tracks`` (T, V) of appearance types ``kind`` (T,), two data each at least, by least squares on the images."""
    if not len(tracks):
        none = np.zeros(0)
        return Places(
            np.zeros((0, 3)), np.zeros((0, 3, 3)), none, np.zeros((0, tracks.shape[1])), none, none.astype(bool)
        )
    observed = _observed(sights, tracks, kind)
    at = _linear(sights, observed)
    for _ in range(STEPS):
        residual, jacobian, _ = _residuals(observed, at)
        at = at - _solved(*_normal(observed, residual, jacobian))
    residual, jacobian, z = _residuals(observed, at)
    normal, _ = _normal(observed, residual, jacobian)
    depth = np.full(tracks.shape, np.nan)
    depth[observed.track, observed.view] = z
    behind = observed.total((z <= NEAREST).astype(float)) > 0
    determined = np.linalg.det(normal) > WORST * (np.trace(normal, axis1=1, axis2=2) / 3.0) ** 3
    good = np.isfinite(at).all(axis=1) & ~behind & determined
    covariance = np.linalg.inv(np.where(good[:, None, None], normal, np.eye(3)))
    return Places(
        at, covariance, observed.total((residual**2).sum(axis=1)), depth, _parallax(sights, at, tracks >= 0), good
    )


def _observed(sights: Sights, tracks: Indices, kind: Indices) -> _Observed:
    track, view = np.nonzero(tracks >= 0)
    first = np.searchsorted(track, np.arange(len(tracks)))
    frames = sights.camera_from_world[view]
    seen, weight = sights.xy[view, tracks[track, view]], 1.0 / sights.sigma[view, kind[track]]
    return _Observed(track, view, first, seen, weight, frames[:, :3, :3], frames[:, :3, 3])


def _linear(sights: Sights, observed: _Observed) -> Floats:
    """(T, 3) the points nearest to the lines of sight."""
    rays = np.column_stack([observed.seen, np.ones(len(observed.seen))])
    rays = (rays[:, None] @ observed.R)[:, 0]
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    across = np.eye(3) - rays[:, :, None] * rays[:, None]
    moved = (across @ sights.eye[observed.view][..., None])[..., 0]
    return _solved(observed.total(across), observed.total(moved))


def _solved(matrix: Floats, right: Floats) -> Floats:
    """(T, 3) the solutions; a hair on the diagonal keeps singular systems finite, ``good`` tells them later."""
    size = np.trace(matrix, axis1=1, axis2=2)[:, None, None]
    solution = np.linalg.solve(matrix + np.eye(3) * (1e-12 * size + 1e-30), right[..., None])
    return np.asarray(solution[..., 0])


def _normal(observed: _Observed, residual: Floats, jacobian: Floats) -> tuple[Floats, Floats]:
    """The normal equations: (T, 3, 3) and (T, 3)."""
    turned = np.swapaxes(jacobian, 1, 2)
    return observed.total(turned @ jacobian), observed.total((turned @ residual[..., None])[..., 0])


def _residuals(observed: _Observed, at: Floats) -> tuple[Floats, Floats, Floats]:
    """Residuals (O, 2) in standard deviations, their derivatives by the place (O, 2, 3), depths (O,) m."""
    points = (observed.R @ at[observed.track][..., None])[..., 0] + observed.t
    z = points[:, 2]
    safe = np.where(np.abs(z) > NEAREST, z, NEAREST)
    ideal = points[:, :2] / safe[:, None]
    jacobian = (observed.R[:, :2] - ideal[..., None] * observed.R[:, 2:]) * (observed.weight / safe)[:, None, None]
    return (ideal - observed.seen) * observed.weight[:, None], jacobian, z


def _parallax(sights: Sights, at: Floats, mask: Mask) -> Floats:
    sight = at[:, None] - sights.eye
    sight /= np.maximum(np.linalg.norm(sight, axis=-1, keepdims=True), 1e-12)
    cosine = sight @ np.swapaxes(sight, 1, 2)
    both = mask[:, :, None] & mask[:, None]
    return np.arccos(np.clip(np.where(both, cosine, 1.0).min(axis=(1, 2)), -1.0, 1.0))
