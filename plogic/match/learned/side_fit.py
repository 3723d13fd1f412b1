"""Sides of edges that agree with many coarse poses at once: what poses are refined on besides pairs of keypoints.

* ``SideFit``: of H poses, at most Q appearances each, the sides that are theirs, and how well they fit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.screen_angles import screen_angle
from plogic.match.gamma.side_looks import looks_fit
from plogic.match.judged.evidence import MOST_HIT
from plogic.match.learned.held_lobes import first_held
from plogic.match.learned.side_pairs import side_pairs
from plogic.match.learned.sides import ALONG

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_index import LearnedIndex
    from plogic.match.learned.side_pairs import SidePairs

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

LOOSE = 0.25
"""Standard deviation, radians, by which a side faces another way where the pose is coarse."""


@dataclass(frozen=True)
class SideFit:
    """``points`` (H, Q, 3) m, object frame; ``uv`` (H, Q, 2) pixels; ``across`` (H, Q, 2); ``weight`` (H, Q), 0 where there is none.

    ``worth`` (H,): about the logarithm of how much likelier the sides are of these poses than of clutter.
    """

    points: Floats
    uv: Floats
    across: Floats
    weight: Floats
    worth: Floats


def side_fit(index: LearnedIndex, poses: Floats, data: Data, granularity: float, reach: float, most: int) -> SideFit:
    """Of poses (H, 4, 4), the ``most`` surest sides, each with the best within ``reach`` pixels across its line and a little more along it."""
    pose, lobe = _expected(index, poses, data, granularity, most)
    at = np.einsum("nij,nj->ni", poses[pose, :3, :3], index.places[lobe]) + poses[pose, :3, 3]
    uv = data.camera.project(at)
    angle = screen_angle(np.einsum("nij,nj->ni", poses[pose, :3, :3], index.cloud.up[lobe]), at)
    inside = data.camera.contains(uv)
    pose, lobe, uv, angle = pose[inside], lobe[inside], uv[inside], angle[inside]
    pairs, further = side_pairs(index, data, lobe, uv, angle), ALONG + reach / 3.0
    near = pairs.only((np.abs(pairs.off) <= reach) & (np.abs(pairs.along) <= further))
    sigma = max(reach / 2.5, 1.0)
    fit = np.exp(-0.5 * (near.off / sigma) ** 2 - 0.5 * (near.turned / LOOSE) ** 2) / (
        np.sqrt(2.0 * np.pi) * sigma * 2.0 * further
    )
    fit *= (
        looks_fit(index.looks[lobe[near.place]], data.looks[near.datum], near.colours, data.contrasts)
        / pairs.usual(reach, len(lobe))[near.place]
    )
    best = _best(near, fit)
    place, datum, fit = near.place[best], near.datum[best], fit[best]
    hit = np.minimum(index.cloud.hit[lobe], MOST_HIT)
    gain = np.log1p(-hit)
    gain[place] = np.log1p(hit[place] * (fit - 1.0))
    slot = np.arange(len(pose)) - np.searchsorted(pose, pose)
    table = len(poses), int(slot.max(initial=-1)) + 1
    worth = np.asarray(np.bincount(pose, gain, minlength=len(poses)), float)
    result = SideFit(np.zeros((*table, 3)), np.zeros((*table, 2)), np.zeros((*table, 2)), np.zeros(table), worth)
    result.points[pose, slot] = index.places[lobe]
    result.across[pose, slot] = np.column_stack([np.cos(angle), np.sin(angle)])
    result.uv[pose[place], slot[place]], result.weight[pose[place], slot[place]] = (
        data.uv[datum],
        hit[place] * fit / (fit + 1.0),
    )
    return result


def _best(near: SidePairs, fit: Floats) -> Indices:
    """Of the pairs the one of each place that fits best."""
    order = np.lexsort((near.datum, -fit, near.place))
    return order[np.unique(near.place[order], return_index=True)[1]]


def _expected(index: LearnedIndex, poses: Floats, data: Data, granularity: float, most: int) -> tuple[Indices, Indices]:
    """Poses and the appearances of sides that each expects, the ``most`` of the greatest hit rates."""
    lobes = index.lobes_of_sides
    if not len(lobes.which) or not data.sided.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    viewpoints = -np.einsum("hij,hi->hj", poses[:, :3, :3], poses[:, :3, 3])
    pose, place = first_held(lobes, viewpoints, granularity, most)
    return pose, lobes.which[place]
