"""Which lobes of a learned type hold a viewpoint, or nearly do (§2.7): of thousands of them, at once.

* ``Lobes``: some of a cloud's lobes, in single precision, by column
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import inverse
from plogic.match.learned.agreement import ASIDE, GRAZING

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.learned import LearnedCloud
    from plogic.match.learned.learned_models import LearnedIndex

    Singles = NDArray[np.float32]

_BLOCK = 1024
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
        """(H, M) how far each viewpoint (H, 3), object frame, is along each lobe's axis, and how far it is away, metres."""
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
    for start in range(0, len(lobes.which), _BLOCK):
        held = held_from(lobes.part(start, start + _BLOCK), viewpoints[left], granularity)
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
