"""Which lobes of a learned type hold a viewpoint, or nearly do (§2.7), and how well poses agree with pairs.

Poses agree in place, size, angle and direction of view, all at once.

* ``Agreement``: of H poses with P pairs, those that agree, and how far off they are, ideal pixels
* ``Held``: of those, the ones that hold each pose: one a keypoint and one a feature
* ``Lobes``: some of a cloud's lobes, in single precision, by column
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import inverse
from plogic.match.gamma.data import Data, centre_of
from plogic.match.gamma.grid import screen_angle, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.learned import LearnedCloud
    from plogic.match.learned.keypoints import Pairs
    from plogic.match.learned.learned_models import LearnedIndex

    Singles = NDArray[np.float32]


ASIDE = 0.35
"""Radians that a viewpoint may lie outside the lobe in the vote, whose axes are coarse."""
GRAZING = 1.5
"""A viewpoint farther than this from a lobe's axis sees nothing of it, however wide the lobe."""
SIZES, ANGLES = 0.5, 0.6
"""Greatest logarithm of the ratio of sizes, greatest difference of angles, radians."""
_BLOCK = 64
"""Poses at a time: what they are multiplied to stays in the processor's cache."""


@dataclass(frozen=True)
class Agreement:
    """``pose``, ``pair`` (N,) those that agree, by pose; ``off`` (N,) pixels; ``tolerance`` (H,) pixels."""

    pose: Indices
    pair: Indices
    off: Floats
    tolerance: Floats


def agreement(index: LearnedIndex, poses: Floats, pairs: Pairs, data: Data, share: float, pixels: float) -> Agreement:
    """Of poses (H, 4, 4).

    A pair agrees in place within ``share`` of the object's diameter on the screen plus ``pixels``.

    What is less exact in space, as the middle of a region is, may be farther off by twice its σ, and its residual is
    told as that much smaller.
    """
    f, lobe, datum = data.camera.f, pairs.lobe, pairs.datum
    R, t = poses[:, :3, :3], poses[:, :3, 3]
    places, slack = index.places[lobe], 2.0 * f * index.cloud.sigma[index.cloud.feature[lobe]]
    depth = R[:, 2] @ index.centre + t[:, 2]
    tolerance = share * index.diameter * f / np.maximum(depth, 1e-6) + pixels
    homogeneous = np.column_stack([places, np.ones(len(places))])
    x, y, z = (np.column_stack([R[:, axis], t[:, axis]]) for axis in range(3))
    u, v = (data.ideal[datum] - centre_of(data.camera)).T[:, :, None]
    # Depth times how far off a place is across, and down, and how far it may be: each is one product of matrices.
    of_poses = np.hstack([x, z]), np.hstack([y, z]), np.hstack([tolerance[:, None] * z, np.ones((len(z), 1))])
    of_pairs = (
        *(np.hstack([f * homogeneous, -side * homogeneous]) for side in (u, v)),
        np.hstack([homogeneous, slack[:, None]]),
    )
    h, p, square = _near(*(np.asarray(rows, np.float32) for rows in (*of_poses, *of_pairs)))  # few
    at = np.einsum("nij,nj->ni", R[h], places[p]) + t[h]
    right = at[:, 2] > 1e-6
    right[right] = _right(
        index,
        R[h[right]],
        t[h[right]],
        at[right],
        (lobe[p[right]], data.scale[datum[p[right]]], data.angle[datum[p[right]]]),
        f,
    )
    h, p, square, depth = h[right], p[right], square[right], at[right, 2]
    return Agreement(h, p, np.sqrt(square) / (tolerance[h] * depth + slack[p]) * tolerance[h], tolerance)


def _near(*factors: NDArray[np.float32]) -> tuple[Indices, Indices, Floats]:
    """Poses and pairs that are near, and the square of how far off.

    ``factors``: across, down and reach, of poses (H, K), then of pairs (P, K).
    """
    found = []
    for start in range(0, len(factors[0]), _BLOCK):
        across, down, reach = (
            mine[start : start + _BLOCK] @ its.T for mine, its in zip(factors[:3], factors[3:], strict=True)
        )
        across *= across
        down *= down
        across += down
        reach *= reach
        h, p = np.nonzero(across <= reach)
        found.append((h + start, p, across[h, p]))
    nothing = np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
    h, p, square = (np.concatenate(parts) for parts in zip(*found, nothing, strict=True))
    return h, p, np.asarray(square, float)


def _right(
    index: LearnedIndex, R: Floats, t: Floats, at: Floats, of_pair: tuple[Indices, Floats, Floats], f: float
) -> Mask:
    """(N,) whether pairs (lobe, scale, angle) whose places agree agree in all else.

    N rotations, translations and places, camera's frame.
    """
    lobe, scale, angle = of_pair
    cloud = index.cloud
    line = -np.einsum("nij,ni->nj", R, t) - index.places[lobe]
    along = (line * cloud.axis[lobe]).sum(axis=1)
    right = along > np.cos(np.minimum(cloud.half_angle[lobe] + ASIDE, GRAZING)) * np.linalg.norm(line, axis=1)
    right &= np.abs(np.log(cloud.size[lobe] * f / at[:, 2] / scale)) < SIZES
    turned = screen_angle(np.einsum("nij,nj->ni", R, cloud.up[lobe]), at) - angle
    return np.asarray(right & (np.abs(wrapped(turned)) < ANGLES))


def votes(found: Agreement, pairs: Pairs) -> Floats:
    """(H,) sum over keypoints of their best agreeing pair: its weight, the less the farther off."""
    worth = pairs.weight[found.pair] * np.exp(-2.0 * (found.off / found.tolerance[found.pose]) ** 2)
    best = greatest(found.pose * (pairs.datum.max(initial=0) + 1) + pairs.datum[found.pair], worth)
    return np.asarray(np.bincount(found.pose[best], worth[best], minlength=len(found.tolerance)), float)


def greatest(owner: Indices, worth: Floats) -> Indices:
    """Indices, increasing, of the one of greatest worth (N,) of each owner (N,), of equals the first."""
    order = np.lexsort((-worth, owner))
    return np.sort(order[np.append(True, owner[order[1:]] != owner[order[:-1]])[: len(order)]])


@dataclass(frozen=True)
class Held:
    """Of H poses what they are held by: ``pose``, ``pair`` (N,), by pose, one a keypoint and one a feature.

    ``weight`` (N,) more than 0.
    """

    pose: Indices
    pair: Indices
    weight: Floats

    def sums(self, count: int, of_pairs: Floats | None = None) -> Floats:
        """(H,) of the weights; or (H, K) of them times what pairs (P, K) are. ``count``: H."""
        if of_pairs is None:
            return np.asarray(np.bincount(self.pose, self.weight, minlength=count), float)
        return np.column_stack(
            [np.bincount(self.pose, self.weight * column[self.pair], minlength=count) for column in of_pairs.T]
        )


def held_by(found: Agreement, pairs: Pairs, feature: NDArray[np.int64]) -> Held:
    """Of the pairs that agree, the nearer off the better.

    Of one keypoint, then of one feature (P,), only the greatest.
    """
    weight = pairs.weight[found.pair] * np.exp(-0.5 * (1.5 * found.off / found.tolerance[found.pose]) ** 2)
    pose, pair = found.pose, found.pair
    for owner in (pairs.datum, feature):
        best = greatest(pose * (int(owner.max(initial=0)) + 1) + owner[pair], weight)
        pose, pair, weight = pose[best], pair[best], weight[best]
    return Held(pose, pair, weight)


_LOBES_BLOCK = 1024
"""Lobes at a time, where few are wanted."""


@dataclass(frozen=True, eq=False)
class Lobes:
    """``which`` (M,) lobes of the cloud; ``axes`` and ``places`` (3, M), from ``centre`` (3,), object frame, metres.

    ``along`` (M,) each place along its axis, ``square`` (M,) its squared distance; ``narrow`` (M,) the cosine of each
    half angle, ``wide`` of one that is greater by ``ASIDE``; ``near``, ``far`` (M,) ranges at the reference focal
    length.
    """

    which: Indices
    centre: Floats
    axes: Singles
    places: Singles
    along: Singles
    square: Singles
    narrow: Singles
    wide: Singles
    near: Singles
    far: Singles

    def seen_from(self, viewpoints: Floats) -> tuple[Singles, Singles]:
        """(H, M) how far each viewpoint (H, 3), object frame, is along each lobe's axis, and its distance, metres."""
        away = (viewpoints - self.centre).astype(np.float32)
        apart = (away * away).sum(axis=1)[:, None] - 2.0 * (away @ self.places) + self.square
        return away @ self.axes - self.along, np.sqrt(np.maximum(apart, 0.0))

    def part(self, first: int, last: int) -> Lobes:
        """Those from one place among them to before another."""
        some: dict[str, Any] = {
            f.name: getattr(self, f.name)[..., first:last] for f in fields(self) if f.name != "centre"
        }
        return Lobes(centre=self.centre, **some)


def lobes_of(cloud: LearnedCloud, which: Indices, centre: Floats) -> Lobes:
    """The lobes ``which`` (M,) of a cloud."""
    axis, half, places = cloud.axis[which], cloud.half_angle[which], cloud.at[cloud.feature[which]] - centre
    columns = (
        axis.T, places.T, (axis * places).sum(axis=1), (places * places).sum(axis=1),
        np.cos(half), np.cos(np.minimum(half + ASIDE, GRAZING)), cloud.r_min[which], cloud.r_max[which],
    )  # fmt: skip
    return Lobes(which, centre, *(np.ascontiguousarray(column, np.float32) for column in columns))


def held_from(lobes: Lobes, viewpoints: Floats, granularity: float) -> Mask:
    """(H, M) whether each lobe holds each viewpoint (H, 3), object frame.

    ``granularity``: f over that at which ranges are told.
    """
    along, distance = lobes.seen_from(viewpoints)
    scale = np.float32(granularity)
    return np.asarray(
        (along >= lobes.narrow * distance) & (distance >= lobes.near * scale) & (distance <= lobes.far * scale)
    )


def first_held(lobes: Lobes, viewpoints: Floats, granularity: float, most: int) -> tuple[Indices, Indices]:
    """Viewpoints, increasing, and places among the lobes, of those that hold each: at most so many, the first."""
    count, left, found = np.zeros(len(viewpoints), np.intp), np.arange(len(viewpoints)), []
    for start in range(0, len(lobes.which), _LOBES_BLOCK):
        held = held_from(lobes.part(start, start + _LOBES_BLOCK), viewpoints[left], granularity)
        viewpoint, place = np.nonzero(held & (np.cumsum(held, axis=1) <= (most - count[left])[:, None]))
        found.append((left[viewpoint], place + start))
        count[left] += held.sum(axis=1)
        left = left[count[left] < most]
        if not len(left):
            break
    nothing = np.zeros(0, np.intp)
    viewpoint, place = (
        np.concatenate([*parts, nothing]) for parts in (zip(*found, strict=True) if found else ((), ()))
    )
    order = np.argsort(viewpoint, kind="stable")
    return viewpoint[order], place[order]


def lobes_held(index: LearnedIndex, pose: Floats, granularity: float) -> Indices:
    """Indices of the lobes that hold the viewpoint (§2.7)."""
    return np.flatnonzero(held_from(index.lobes, inverse(pose)[None, :3, 3], granularity)[0])


def lobes_about(index: LearnedIndex, pose: Floats) -> Indices:
    """Indices of the lobes of keypoints that hold the viewpoint, or would if they were wider by ``ASIDE``."""
    along, distance = index.lobes_of_points.seen_from(inverse(pose)[None, :3, 3])
    return index.lobes_of_points.which[along[0] >= index.lobes_of_points.wide * distance[0]]
