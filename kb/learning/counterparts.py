"""Where a motion takes a learned cloud's appearances, and which others stand there already, looking alike: what symmetries are measured by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kb.learning.again import ALIKE, differences, flat

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from kb.clouds.learned import LearnedCloud
    from kb.learning.observations import Observations

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

TOGETHER, SAME_UP, SAME_SIZE = 0.85, 0.8, 0.3
"""Least cosines between directions of view and between ``up``, greatest logarithm of the ratio of sizes, of two that
are alike."""
ROUNDS = (0.025, 0.015, 0.01, 0.006)
"""How far apart, in diameters, counterparts may stand while a motion is settled: scans are no exact shapes, and their
boxes no exact axes."""
SIGMAS = 3.0 * 2.0**0.5
"""How far apart they may stand afterwards, in the cloud's median location noise; both have it."""
BLOCK = 1_000_000
"""Pairs of appearances that are compared at a time."""


def reach_of(cloud: LearnedCloud) -> float:
    """Metres within which two appearances are at one place."""
    return SIGMAS * float(np.median(cloud.sigma))


def counterparts(
    cloud: LearnedCloud, motion: Floats, reach: float, descriptor: NDArray[np.uint8] | None = None
) -> tuple[Indices, Indices, Floats]:
    """Appearances, their counterparts after ``motion`` (4, 4), and how far apart the descriptors of the two are.

    ``descriptor`` (L, D) takes the place of those of what is moved.
    """
    R, t = motion[:3, :3], motion[:3, 3]
    axis, up, moving = cloud.axis @ R.T, cloud.up @ R.T, cloud.descriptor if descriptor is None else descriptor
    found: list[tuple[Indices, Indices, Floats]] = []
    for a, b in _near(cloud, cloud.at @ R.T + t, reach):
        like = _alike(axis[a], cloud.axis[b], TOGETHER) & _alike(up[a], cloud.up[b], SAME_UP)
        like &= np.abs(np.log(cloud.size[a] / cloud.size[b])) < SAME_SIZE
        some, its = a[like], b[like]
        apart = differences(moving[some], cloud.descriptor[its])
        close = apart < ALIKE[cloud.descriptor.shape[1]]
        found.append((some[close], its[close], apart[close]))
    if not found:
        return np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
    return (
        np.concatenate([f[0] for f in found]),
        np.concatenate([f[1] for f in found]),
        np.concatenate([f[2] for f in found]),
    )


def _alike(some: Floats, others: Floats, least: float) -> NDArray[np.bool_]:
    return np.asarray((some * others).sum(axis=1) > least)


def _near(cloud: LearnedCloud, moved: Floats, reach: float) -> Iterator[tuple[Indices, Indices]]:
    """Blocks of pairs of appearances, of features that are ``moved`` (F, 3) to within ``reach`` of others."""
    from scipy.spatial import cKDTree

    i, j = flat(cKDTree(cloud.at).query_ball_point(moved, reach, return_sorted=True))
    counts = np.bincount(cloud.feature, minlength=len(cloud.at))
    start, pairs = np.cumsum(counts) - counts, counts[i] * counts[j]
    ends = np.searchsorted(np.cumsum(pairs), np.arange(BLOCK, pairs.sum() + BLOCK, BLOCK), side="left") + 1
    for low, high in zip([0, *ends.tolist()], ends.tolist(), strict=False):
        some, its, size = i[low:high], j[low:high], pairs[low:high]
        which = np.repeat(np.arange(len(some)), size)
        number = np.arange(len(which)) - np.repeat(np.cumsum(size) - size, size)
        width = counts[its][which]
        yield start[some][which] + number // width, start[its][which] + number % width


def share(cloud: LearnedCloud, found: Indices) -> float:
    """What the appearances ``found``, each counted once, are of all, by their hit rates."""
    return float(cloud.hit[np.unique(found)].sum() / max(float(cloud.hit.sum()), 1e-12))


def settled(cloud: LearnedCloud, motion: Floats, diameter: float) -> Floats:
    """The motion (4, 4) moved onto what looks alike, ever more tightly; as it was where there is too little."""
    for near in ROUNDS:
        a, b, apart = counterparts(cloud, motion, near * diameter)
        order = np.lexsort((b, apart, a))
        first = np.unique(a[order], return_index=True)[1]
        if len(first) < 10:
            break
        motion = _fitted(cloud, motion, a[order][first], b[order][first])
    return motion


def _fitted(cloud: LearnedCloud, motion: Floats, a: Indices, b: Indices) -> Floats:
    """The motion that takes the appearances ``a`` nearest to ``b`` (Kabsch), by their hit rates."""
    moved = cloud.at[cloud.feature[a]] @ motion[:3, :3].T + motion[:3, 3]
    there, weight = cloud.at[cloud.feature[b]], np.maximum(cloud.hit[a], 1e-9)
    middle, its = np.average(moved, axis=0, weights=weight), np.average(there, axis=0, weights=weight)
    u, _, v = np.linalg.svd((moved - middle).T @ ((there - its) * weight[:, None]))
    turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v).T
    step = np.eye(4)
    step[:3, :3], step[:3, 3] = turn, its - turn @ middle
    return np.asarray(step @ motion)


def seen_again(cloud: LearnedCloud, motion: Floats, seen: Observations, directions: Floats) -> float:
    """Share of the appearances, moved by ``motion`` (4, 4), that new pictures from ``directions`` (V, 3) show, of those that they should.

    By hit rates: what the detector would report of the object in this place, if it stood in that.
    """
    from scipy.spatial import cKDTree

    R, t = motion[:3, :3], motion[:3, 3]
    at, axis, up = cloud.at @ R.T + t, cloud.axis @ R.T, cloud.up @ R.T
    due, got = 0.0, 0.0
    for view, direction in enumerate(directions):
        held, own = np.flatnonzero(axis @ direction >= np.cos(cloud.half_angle)), np.flatnonzero(seen.view == view)
        due += float(cloud.hit[held].sum())
        if not len(held) or not len(own):
            continue
        i, j = flat(
            cKDTree(seen.at[own]).query_ball_point(at[cloud.feature[held]], reach_of(cloud), return_sorted=True)
        )
        a, b = held[i], own[j]
        like = _alike(up[a], seen.up[b], SAME_UP) & (np.abs(np.log(cloud.size[a] / seen.size[b])) < SAME_SIZE)
        a, b = a[like], b[like]
        shown = np.rint(seen.descriptor[b]).astype(np.uint8)
        close = differences(cloud.descriptor[a], shown) < ALIKE[cloud.descriptor.shape[1]]
        got += float(cloud.hit[np.unique(a[close])].sum())
    return got / max(due, 1e-12)
