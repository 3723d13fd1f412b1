"""Junctions: places where edges meet, typed by their arms (``l_junction`` ... ``multi_junction``).

Segments are found in the picture with its patches painted out (a window's corner is no object's corner), intersected
near their ends, and each place's arms are counted, those included that only the brightness shows.

=====================  ====  ====================================  ==========================================
kind                   arms  configuration                         ``angle``
=====================  ====  ====================================  ==========================================
``l_junction``         2     not straight                          bisector of the inner angle
``y_junction``         3     every gap below 168°                  the arm nearest to straight down (+v)
``t_junction``         3     the largest gap within 180° ± 12°     the stem
``arrow_junction``     3     a gap above 192°                      the shaft, the arm opposite that gap
``multi_junction``     4+    any                                   opposite to the largest gap's middle
=====================  ====  ====================================  ==========================================

Arms that no segment showed: directions from a place along which the brightness differs steadily from one side to the
other.

Painting patches out: the picture as if its walls were bare, so that a window's border is no object's edge.

Where segments meet: pairs of lines intersected near their ends, gathered to places, each with its arms.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Mask
from sensing.appearance import Appearance
from sensing.detectors.edges import directions, find_segments, meet, sample
from sensing.detectors.patches import areas, find_patches

MIN_ANGLE = np.radians(12.0)
"""Two segments closer in direction than this do not fix a place."""
REACH = (3.5, 12.0)
"""Pixels by which a segment may fall short of the place: a fifth of its length, within these."""
OVERSHOOT = 4.5
"""Pixels by which it may run past the place and still end there; beyond, it passes through."""
GATHER = 3.0
"""Pixels: meetings closer than this are one place."""


RIM = (1.2, 2.2)
"""Least and most pixels by which a patch is painted out beyond its border: 0.3 of its width, within these."""


DIRECTIONS = 120
RADII = np.arange(5.0, 15.0)
SIDE = 1.8
"""Pixels to either side of the ray at which brightness is compared."""
FAR_SIDE, SHARPNESS = 4.0, 0.75
"""At an edge most of the difference at 4 px is there at 1.8 px already; on a slope it is not."""
MIN_STEP = 10.0
"""Grey levels by which the sides differ in the mean."""
LEAST = 0.7
"""Share of the step that each third of the ray shows at least."""
APART = np.radians(22.0)
"""An arm is not sought nearer than this to another."""


TYPES = ("l_junction", "y_junction", "arrow_junction", "t_junction", "multi_junction")
STRAIGHT = np.radians(12.0)
"""A gap this near to 180° counts as straight."""


class JunctionDetector:
    """Reports junctions with ``angle`` and ``arms`` (see the module), ``scale`` (the shortest arm) and ``score``."""

    name = "junction"
    types: tuple[str, ...] = TYPES

    def detect(self, image_bgr: Bytes) -> list[Appearance]:
        """Junctions of an (H, W, 3) uint8 image."""
        grey = np.asarray(cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY), np.uint8)
        patches = find_patches(grey).corners
        bare = [without_patches(channel, patches) for channel in _channels(image_bgr, grey)]
        meetings = find_meetings(find_segments(bare))
        if not meetings:
            return []
        places = np.array([m.place for m in meetings])
        soft = [np.asarray(cv2.GaussianBlur(channel, (0, 0), 0.8), np.float32) for channel in bare]
        step, least = (np.max(x, axis=0) for x in zip(*(steps(channel, places) for channel in soft), strict=True))
        height, width = grey.shape
        found = [
            self._appearance(m, *completed(s, low, m.arms, m.lengths))
            for m, s, low in zip(meetings, step, least, strict=True)
        ]
        return [a for a in found if a is not None and 0 <= a.uv[0] <= width - 1 and 0 <= a.uv[1] <= height - 1]

    def _appearance(self, meeting: "Meeting", arms: Floats, lengths: Floats) -> Appearance | None:
        named = kind(arms)
        if named is None:
            return None
        a_type, angle = named
        score = float(np.clip(lengths.min() / 20, 0.1, 1) / (1 + meeting.gap / 4))
        uv = (float(meeting.place[0]), float(meeting.place[1]))
        return Appearance("", a_type, uv, self.name, angle, float(lengths.min()), score, tuple(float(x) for x in arms))


def _channels(image_bgr: Bytes, grey: Bytes) -> list[NDArray[np.float32]]:
    """Brightness, and warm against cold (red minus blue, halved).

    An edge between equally bright colours shows in the second alone.
    """
    warm = (image_bgr[:, :, 2].astype(np.float32) - image_bgr[:, :, 0].astype(np.float32)) / 2 + 128
    return [grey.astype(np.float32), warm.astype(np.float32)]


def kind(arms: Floats) -> tuple[str, float] | None:
    """The type and angle of a junction of arms (k,) ascending in [0, 2π); None for fewer than two or a line."""
    if len(arms) < 2:
        return None
    gaps = np.mod(np.roll(arms, -1) - arms, 2 * np.pi)
    widest = int(np.argmax(gaps))
    inner = _direction(arms[widest] + gaps[widest] / 2 + np.pi)
    if len(arms) == 2:
        return None if abs(gaps[widest] - np.pi) < STRAIGHT else ("l_junction", inner)
    if len(arms) > 3:
        return "multi_junction", inner
    opposite = _direction(arms[(widest + 2) % 3])
    if gaps[widest] > np.pi + STRAIGHT:
        return "arrow_junction", opposite
    if gaps[widest] > np.pi - STRAIGHT:
        return "t_junction", opposite
    return "y_junction", _direction(arms[int(np.argmax(np.sin(arms)))])


def _direction(angle: float) -> float:
    return float(np.mod(angle, 2 * np.pi))


def steps(grey: NDArray[np.float32], places: Floats) -> tuple[Floats, Floats]:
    """Along each ray from (N, 2) places.

    How much its sides differ in the mean (N, D), and in the third where they differ least (N, D).

    The latter is 0 where the brightness slopes instead of stepping.
    """
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-ray[:, 1], ray[:, 0]], axis=1)
    on = places[:, None, None] + RADII[None, None, :, None] * ray[None, :, None]
    near, far = (_difference(grey, on, reach * across) for reach in (SIDE, FAR_SIDE))
    mean = near.mean(axis=2)
    thirds = np.stack([part.mean(axis=2) for part in np.array_split(near, 3, axis=2)], axis=2)
    least = (thirds * np.sign(mean)[:, :, None]).min(axis=2)
    sharp = np.abs(mean) >= SHARPNESS * np.abs(far.mean(axis=2))
    return np.abs(mean), np.where(sharp, least, 0.0)


def _difference(grey: NDArray[np.float32], on: Floats, across: Floats) -> Floats:
    return (sample(grey, on + across[None, :, None]) - sample(grey, on - across[None, :, None])).astype(np.float64)


def completed(step: Floats, least: Floats, arms: Floats, lengths: Floats) -> tuple[Floats, Floats]:
    """Arms (k,) with those added that the steps (D,) of one place show, the strongest first.

    An added arm is as long as was looked at.
    """
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    peak = (step >= np.roll(step, 1)) & (step > np.roll(step, -1)) & (step >= MIN_STEP) & (least >= LEAST * step)
    wide = round(APART / (2 * np.pi / DIRECTIONS))
    peak &= step > 1.3 * np.maximum(np.roll(step, wide), np.roll(step, -wide))
    for k in np.flatnonzero(peak)[np.argsort(-step[peak], kind="stable")]:
        if np.all(np.abs(np.angle(np.exp(1j * (arms - angle[k])))) > APART):
            arms, lengths = np.append(arms, angle[k]), np.append(lengths, RADII[-1])
    return distinct(arms, lengths)


def without_patches(grey: NDArray[np.float32], corners: Floats) -> NDArray[np.float32]:
    """A copy of the (H, W) picture where each of the (N, 4, 2) patches has the median brightness around it."""
    out = grey.copy()
    if not len(corners):
        return out
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    by = np.clip(0.3 * areas(corners) / np.maximum(sides.max(axis=1), 1e-9), *RIM)
    around = np.median(sample(grey, _rim(_grown(corners, by + 0.7))), axis=1)
    for quad, level in zip(_grown(corners, by), around, strict=True):
        cv2.fillConvexPoly(out, np.rint(quad * 16).astype(np.int32), float(level), shift=4)
    return out


def _grown(corners: Floats, by: Floats) -> Floats:
    """Each side moved out by ``by`` (N,) pixels."""
    along = np.roll(corners, -1, axis=1) - corners
    along = along / np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-9)
    out = np.stack([along[:, :, 1], -along[:, :, 0]], axis=2)
    moved = corners + by[:, None, None] * out
    return np.nan_to_num(meet(np.roll(moved, 1, axis=1), np.roll(along, 1, axis=1), moved, along), nan=-1.0)


def _rim(corners: Floats) -> Floats:
    """(N, 12, 2) places: three along each side."""
    following = np.roll(corners, -1, axis=1)
    return np.concatenate([corners * (1 - t) + following * t for t in (0.2, 0.5, 0.8)], axis=1)


@dataclass(frozen=True)
class Meeting:
    """A place (u, v) where segments meet.

    ``arms`` (k,) directions in radians away from it, ``lengths`` (k,) in pixels, ``gap`` mean px.
    """

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
    """Pairs (P,), (P,) that meet, their places (P, 2) and costs (P,).

    What is missing at the ends, dearer for short lines.
    """
    along, _, length = directions(segments)
    i, j = np.triu_indices(len(segments), 1)
    place = meet(segments[i, :2], along[i], segments[j, :2], along[j])
    cross = np.abs(along[i, 0] * along[j, 1] - along[i, 1] * along[j, 0])
    gaps, through = zip(*(_gap(segments[k], along[k], length[k], place) for k in (i, j)), strict=True)
    near = [g <= np.clip(0.2 * length[k], *REACH) for g, k in zip(gaps, (i, j), strict=True)]
    good = (cross > np.sin(MIN_ANGLE)) & near[0] & near[1] & ~(through[0] & through[1])
    cost = gaps[0] + gaps[1] + 30 / np.minimum(length[i], length[j]) + 0.5 / np.maximum(cross, 1e-6)
    return i[good], j[good], place[good], cost[good]


def _gap(segments: Floats, along: Floats, length: Floats, place: Floats) -> tuple[Floats, Mask]:
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
    """(2,) place with the least weighted squared distances from lines.

    ``start`` where they fix none within 3 px of it.
    """
    A = np.einsum("n,ni,nj->ij", weights, normals, normals)
    b = np.einsum("n,ni,n->i", weights, normals, (points * normals).sum(axis=1))
    if np.linalg.det(A) < 1e-6 * np.trace(A) ** 2:
        return start
    place = np.linalg.solve(A, b)
    return np.asarray(place if np.linalg.norm(place - start) < GATHER else start)


def _arms(segments: Floats, along: Floats, length: Floats, place: Floats) -> tuple[Floats, Floats]:
    """Directions and lengths of the arms: where a segment runs on by more than the overshoot.

    Near-equal directions once, the longest.
    """
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
