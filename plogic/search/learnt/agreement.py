"""How well poses agree with pairs: in place, size, angle and direction of view, all at once.

* ``Agreement``: of H poses with P pairs, those that agree, and how far off they are, ideal pixels
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.data import centre_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex
    from plogic.search.learnt.pairs import Pairs

    Floats = NDArray[np.float64]

ASIDE = 0.35
"""Radians that a viewpoint may lie outside the lobe in the vote, whose axes are coarse."""
GRAZING = 1.5
"""A viewpoint farther than this from a lobe's axis sees nothing of it, however wide the lobe."""
SIZES, ANGLES = 0.5, 0.6
"""Greatest logarithm of the ratio of sizes, greatest difference of angles, radians."""


@dataclass(frozen=True)
class Agreement:
    """``pose``, ``pair`` (N,) those that agree, ``off`` (N,) pixels; ``tolerance`` (H,) pixels; ``pairs``: how many there are, P."""

    pose: NDArray[np.intp]
    pair: NDArray[np.intp]
    off: Floats
    tolerance: Floats
    pairs: int

    @property
    def residual(self) -> Floats:
        """(H, P) pixels, inf where a pair contradicts."""
        result = np.full((len(self.tolerance), self.pairs), np.inf)
        result[self.pose, self.pair] = self.off
        return result


def agreement(index: LearntIndex, poses: Floats, pairs: Pairs, data: Data, share: float, pixels: float) -> Agreement:
    """Of poses (H, 4, 4); a pair agrees in place within ``share`` of the object's diameter on the screen plus ``pixels``.

    What is less exact in space, as the middle of a region is, may be farther off by twice its σ, and its residual is told as that much smaller.
    """
    f, lobe, datum = data.camera.f, pairs.lobe, pairs.datum
    R, t = poses[:, :3, :3], poses[:, :3, 3]
    places, ideal = index.places[lobe].astype(np.float32), (data.ideal[datum] - centre_of(data.camera)).astype(np.float32)
    x, y, z = (R[:, axis].astype(np.float32) @ places.T + t[:, axis, None].astype(np.float32) for axis in range(3))
    pixels_a_metre = np.float32(f) / np.maximum(z, np.float32(1e-6))
    across, down = x * pixels_a_metre - ideal[:, 0], y * pixels_a_metre - ideal[:, 1]
    tolerance = share * index.diameter * f / np.maximum(R[:, 2] @ index.centre + t[:, 2], 1e-6) + pixels
    slack = 2.0 * index.cloud.sigma[index.cloud.feature[lobe]].astype(np.float32) * pixels_a_metre
    square, reach = across * across + down * down, tolerance[:, None].astype(np.float32) + slack
    h, p = np.nonzero((square <= reach * reach) & (z > 1e-6))  # few
    at = np.column_stack([x[h, p], y[h, p], z[h, p]])
    right = _right(index, R[h], t[h], at, (lobe[p], data.scale[datum[p]], data.angle[datum[p]]), f)
    h, p = h[right], p[right]
    return Agreement(h, p, np.sqrt(square[h, p]) * (tolerance[h] / reach[h, p]), tolerance, len(lobe))


def _right(
    index: LearntIndex, R: Floats, t: Floats, at: Floats, of_pair: tuple[NDArray[np.intp], Floats, Floats], f: float
) -> NDArray[np.bool_]:
    """(N,) whether pairs (lobe, scale, angle) whose places agree agree in all else: N rotations, translations and places, camera's frame."""
    lobe, scale, angle = of_pair
    cloud = index.cloud
    line = -np.einsum("nij,ni->nj", R, t) - index.places[lobe]
    along = (line * cloud.axis[lobe]).sum(axis=1)
    right = along > np.cos(np.minimum(cloud.half_angle[lobe] + ASIDE, GRAZING)) * np.linalg.norm(line, axis=1)
    right &= np.abs(np.log(cloud.size[lobe] * f / at[:, 2] / scale)) < SIZES
    turned = screen_angle(np.einsum("nij,nj->ni", R, cloud.up[lobe]), at) - angle
    return np.asarray(right & (np.abs((turned + np.pi) % (2.0 * np.pi) - np.pi) < ANGLES))


def screen_angle(direction: Floats, at: Floats) -> Floats:
    """Angle on the screen, radians clockwise from +x, of a direction (…, 3) in space at a place (…, 3), both in the camera's frame."""
    du = direction[..., 0] * at[..., 2] - at[..., 0] * direction[..., 2]
    dv = direction[..., 1] * at[..., 2] - at[..., 1] * direction[..., 2]
    return np.asarray(np.arctan2(dv, du))


def votes(found: Agreement, pairs: Pairs) -> Floats:
    """(H,) sum over keypoints of their best agreeing pair: its weight, the less the farther off."""
    worth = pairs.weight[found.pair] * np.exp(-2.0 * (found.off / found.tolerance[found.pose]) ** 2)
    order = np.lexsort((worth, pairs.datum[found.pair], found.pose))
    pose, datum, worth = found.pose[order], pairs.datum[found.pair[order]], worth[order]
    best = np.append((pose[1:] != pose[:-1]) | (datum[1:] != datum[:-1]), True)[: len(pose)]
    return np.asarray(np.bincount(pose[best], worth[best], minlength=len(found.tolerance)), float)


def one_to_one(weights: Floats, pairs: Pairs, feature: NDArray[np.int64]) -> Floats:
    """(H, P) the same, but of the pairs of one keypoint, then of one feature (P,), only the greatest is kept."""
    for owner in (pairs.datum, feature):
        order = np.argsort(owner, kind="stable")
        starts = np.unique(owner[order], return_index=True)[1]
        lengths = np.diff([*starts, len(order)])
        top = np.maximum.reduceat(weights[:, order], starts, axis=1).repeat(lengths, axis=1)
        kept = np.zeros_like(weights)
        kept[:, order] = np.where(weights[:, order] == top, weights[:, order], 0.0)
        weights = kept
    return weights
