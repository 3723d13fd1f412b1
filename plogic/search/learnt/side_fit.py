"""Sides of edges that agree with many coarse poses at once: what poses are refined on besides pairs of keypoints.

* ``SideFit``: of H poses, at most Q appearances each, the sides that are theirs, and how well they fit
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.evidence import MOST_HIT
from plogic.search.learnt.agreement import screen_angle
from plogic.search.learnt.lobes import held_from
from plogic.search.learnt.side_grid import TURNS
from plogic.search.learnt.side_looks import colours_off, looks_fit
from plogic.search.learnt.sides import ALONG, AROUND, FEW

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

TURNED, LOOSE = 2.0 * np.pi / TURNS, 0.25
"""Radians by which a side may face another way where the pose is coarse, as far as the grid looks, and the standard deviation of it."""


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


def side_fit(index: LearntIndex, poses: Floats, data: Data, granularity: float, reach: float, most: int) -> SideFit:
    """Of poses (H, 4, 4), the ``most`` surest sides, each with the best within ``reach`` pixels across its line and a little more along it."""
    pose, lobe = _expected(index, poses, data, granularity, most)
    at = np.einsum("nij,nj->ni", poses[pose, :3, :3], index.places[lobe]) + poses[pose, :3, 3]
    uv = data.camera.project(at)
    angle = screen_angle(np.einsum("nij,nj->ni", poses[pose, :3, :3], index.cloud.up[lobe]), at)
    inside = data.camera.contains(uv)
    pose, lobe, uv, angle = pose[inside], lobe[inside], uv[inside], angle[inside]
    inward = np.column_stack([np.cos(angle), np.sin(angle)])
    place, datum = data.sides.near(uv, angle)
    turned = (data.angle[datum] - angle[place] + np.pi) % (2.0 * np.pi) - np.pi
    facing = np.abs(turned) < TURNED
    place, datum, turned = place[facing], datum[facing], turned[facing]
    colours = colours_off(index.looks[lobe[place]], data.looks[datum], coloured=data.coloured)
    right = colours < 1.0
    place, datum, turned, colours = place[right], datum[right], turned[right], colours[right]
    apart = data.uv[datum] - uv[place]
    off = (apart * inward[place]).sum(axis=1)
    along = apart[:, 1] * inward[place, 0] - apart[:, 0] * inward[place, 1]
    within = np.abs(off) <= reach
    clutter = ~within & (off**2 + along**2 < AROUND**2)
    usual = (np.bincount(place[clutter], minlength=len(lobe)) + FEW) / (np.pi * AROUND**2 - 4.0 * AROUND * reach)
    near = np.flatnonzero(within & (np.abs(along) <= ALONG + reach / 3.0))
    sigma = max(reach / 2.5, 1.0)
    fit = np.exp(-0.5 * (off[near] / sigma) ** 2 - 0.5 * (turned[near] / LOOSE) ** 2) / (np.sqrt(2.0 * np.pi) * sigma * 2.0 * (ALONG + reach / 3.0))
    fit *= looks_fit(index.looks[lobe[place[near]]], data.looks[datum[near]], colours[near]) / usual[place[near]]
    near, fit = _best(near, fit, place, datum)
    hit = np.minimum(index.cloud.hit[lobe], MOST_HIT)
    gain = np.log1p(-hit)
    gain[place[near]] = np.log1p(hit[place[near]] * (fit - 1.0))
    weight = np.zeros(len(lobe))
    weight[place[near]] = hit[place[near]] * fit / (fit + 1.0)
    seen = np.zeros(len(lobe), np.intp)
    seen[place[near]] = datum[near]
    worth = np.asarray(np.bincount(pose, gain, minlength=len(poses)), float)
    slot = np.arange(len(pose)) - np.searchsorted(pose, pose)
    widest = int(slot.max(initial=-1)) + 1
    table = len(poses), widest
    result = SideFit(np.zeros((*table, 3)), np.zeros((*table, 2)), np.zeros((*table, 2)), np.zeros(table), worth)
    result.points[pose, slot], result.uv[pose, slot] = index.places[lobe], data.uv[seen] if len(seen) else 0.0
    result.across[pose, slot], result.weight[pose, slot] = inward, weight
    return result


def _best(near: Indices, fit: Floats, place: Indices, datum: Indices) -> tuple[Indices, Floats]:
    """Of the pairs ``near`` (N,) the one of each place that fits best."""
    order = np.lexsort((datum[near], -fit, place[near]))
    first = order[np.unique(place[near][order], return_index=True)[1]]
    return near[first], fit[first]


def _expected(index: LearntIndex, poses: Floats, data: Data, granularity: float, most: int) -> tuple[Indices, Indices]:
    """Poses and the appearances of sides that each expects, the ``most`` of the greatest hit rates."""
    sides = np.flatnonzero(index.cloud.sided)
    if not len(sides) or not data.sided.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    viewpoints = -np.einsum("hij,hi->hj", poses[:, :3, :3], poses[:, :3, 3])
    pose, lobe = np.nonzero(held_from(index, viewpoints, granularity)[:, sides])
    order = np.lexsort((-index.cloud.hit[sides[lobe]], pose))
    pose, lobe = pose[order], sides[lobe[order]]
    sure = np.arange(len(pose)) - np.searchsorted(pose, pose) < most
    return pose[sure], lobe[sure]
