"""Where segments meet: pairs of lines intersected near their ends, gathered to places, each with its arms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sensing.detectors.edges import directions, meet

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

MIN_ANGLE = np.radians(12.0)
"""Two segments closer in direction than this do not fix a place."""
REACH = (3.5, 12.0)
"""Pixels by which a segment may fall short of the place: a fifth of its length, within these."""
OVERSHOOT = 4.5
"""Pixels by which it may run past the place and still end there; beyond, it passes through."""
GATHER = 3.0
"""Pixels: meetings closer than this are one place."""


@dataclass(frozen=True)
class Meeting:
    """A place (u, v) where segments meet; ``arms`` (k,) directions in radians away from it, ``lengths`` (k,) in pixels, ``gap`` mean px."""

    place: Floats
    arms: Floats
    lengths: Floats
    gap: float


def find_meetings(segments: Floats) -> list[Meeting]:
    """Meetings of two or more of (N, 4) segments of which at least one ends there."""
    first, second, place, cost = _pairs(segments)
    order = np.argsort(cost, kind="stable")
    free = np.ones(len(order), dtype=bool)
    found = []
    for k in order:
        if not free[k]:
            continue
        mates = free & (np.linalg.norm(place - place[k], axis=1) < GATHER)
        free &= ~mates
        members = np.unique(np.concatenate([first[mates], second[mates]]))
        meeting = _meeting(segments[members], place[k])
        if len(meeting.arms) >= 2:
            found.append(meeting)
    return found


def _pairs(segments: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats, Floats]:
    """Pairs (P,), (P,) that meet, their places (P, 2) and costs (P,): what is missing at the ends, dearer for short lines."""
    along, _, length = directions(segments)
    i, j = np.triu_indices(len(segments), 1)
    place = meet(segments[i, :2], along[i], segments[j, :2], along[j])
    cross = np.abs(along[i, 0] * along[j, 1] - along[i, 1] * along[j, 0])
    gaps, through = zip(*(_gap(segments[k], along[k], length[k], place) for k in (i, j)), strict=True)
    near = [g <= np.clip(0.2 * length[k], *REACH) for g, k in zip(gaps, (i, j), strict=True)]
    good = (cross > np.sin(MIN_ANGLE)) & near[0] & near[1] & ~(through[0] & through[1])
    cost = gaps[0] + gaps[1] + 30 / np.minimum(length[i], length[j]) + 0.5 / np.maximum(cross, 1e-6)
    return i[good], j[good], place[good], cost[good]


def _gap(segments: Floats, along: Floats, length: Floats, place: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Pixels (P,) by which a segment falls short of the place, and whether it passes through."""
    t = ((place - segments[:, :2]) * along).sum(axis=1)
    return np.maximum(np.maximum(-t, t - length), 0), (t > OVERSHOOT) & (t < length - OVERSHOOT)


def _meeting(segments: Floats, start: Floats) -> Meeting:
    """The place that suits all its segments best, and the arms that leave it."""
    along, normal, length = directions(segments)
    place = start
    weights = np.ones(len(segments))
    for _ in range(3):
        t = ((place - segments[:, :2]) * along).sum(axis=1) / length - 0.5
        off = np.abs(((segments[:, :2] - place) * normal).sum(axis=1))
        weights = length / (1 + 12 * t**2) / (1 + off**2)
        place = _nearest(segments[:, :2], normal, weights, start)
    gap, _ = _gap(segments, along, length, np.repeat(place[None], len(segments), axis=0))
    return Meeting(place, *_arms(segments, along, length, place), float(gap.mean()))


def _nearest(points: Floats, normals: Floats, weights: Floats, start: Floats) -> Floats:
    """(2,) place with the least weighted squared distances from lines; ``start`` where they fix none within 3 px of it."""
    A = np.einsum("n,ni,nj->ij", weights, normals, normals)
    b = np.einsum("n,ni,n->i", weights, normals, (points * normals).sum(axis=1))
    if np.linalg.det(A) < 1e-6 * np.trace(A) ** 2:
        return start
    place = np.linalg.solve(A, b)
    return np.asarray(place if np.linalg.norm(place - start) < GATHER else start)


def _arms(segments: Floats, along: Floats, length: Floats, place: Floats) -> tuple[Floats, Floats]:
    """Directions and lengths of the arms: where a segment runs on by more than the overshoot; near-equal directions once, the longest."""
    t = ((place - segments[:, :2]) * along).sum(axis=1)
    angles = np.concatenate([np.arctan2(along[:, 1], along[:, 0]), np.arctan2(-along[:, 1], -along[:, 0])])
    lengths = np.concatenate([length - t, t])
    return distinct(angles[lengths > OVERSHOOT], lengths[lengths > OVERSHOOT])


def distinct(angles: Floats, lengths: Floats, apart: float = np.radians(10)) -> tuple[Floats, Floats]:
    """Directions at least ``apart`` from one another, longer ones first served; ascending in [0, 2π)."""
    kept: list[int] = []
    for i in np.argsort(-lengths, kind="stable"):
        if all(abs(np.angle(np.exp(1j * (angles[i] - angles[k])))) > apart for k in kept):
            kept.append(int(i))
    kept.sort(key=lambda i: float(np.mod(angles[i], 2 * np.pi)))
    return np.mod(angles[kept], 2 * np.pi), lengths[kept]
