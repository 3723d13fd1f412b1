"""Poses of a type that its views suggest anywhere in a photo.

* ``searched(photo, camera, body, most)``: the best of them, no two alike

Every view, turned about the sight line by even steps, is laid over every place in every size, on maps of cells of
``EVERY`` pixels; the best of these climb over more views on maps of pixels; no two alike.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats, Indices
from geometry.camera import Camera
from geometry.frames import least_turns
from sensing.views.loops import apart, climbed, offsets, scanned
from sensing.views.maps import UNIT, PhotoMaps, TypeMaps
from sensing.views.views import Views

SIZES = 40.0, 300.0, 1.3
"""Pixels of a diameter, and the step from one size to the next."""
TURNS = 12
"""Of a view about the sight line."""
COARSE, FINE = 48.0, 72.0
"""Pixels that a diameter has at most, about, where views are laid over all places, and where they climb."""
EVERY, SPREAD, SPREAD_FINE = 4, 2, 1
"""Pixels of a cell; pixels by which an edge may be off."""
POWER = 0.3
"""Of the size, by which sums of features, which are not independent, count more in large ones."""
KEPT, SEEDS = 20000, 400
"""Of the best places; and those of them, no two alike, that climb."""
ALIKE_COARSE, ALIKE = (np.radians(10.0), np.log(1.1), 0.06), (np.radians(12.0), np.log(1.13), 0.08)
"""Angle, logarithm of the sizes' ratio, and sizes' share between what is alike."""
STEPS, ROUNDS = np.array([0.14, 0.09, 0.05]), 14
"""First steps of a climb: radians, a share of the size, and of the place in sizes; and rounds at most."""
LAID = 40
"""Views that are laid over all places. Of 89 objects 19, 29 and 35 are right among the first, ten and fifty, in 0.28 s
a type; with 60 views and 800 seeds 19, 30 and 34 in 0.37 s (``python benchmarks/view_seeds.py KB DATASET``)."""


class Body(NamedTuple):
    """``views`` of a type, its ``middle`` (3,) m, object frame, and its ``diameter``, m."""

    views: Views
    middle: Floats
    diameter: float


def searched(photo: PhotoMaps, camera: Camera, body: Body, most: int) -> tuple[Floats, Floats]:
    """Poses (N, 4, 4) of a type and their scores (N,), the best first, at most ``most``."""
    views, maps = body.views, TypeMaps(photo, body.views)
    seeds = everywhere(maps, views)
    turns = turns_of(seeds, views)
    kept = apart(seeds[:, 2:5], turns, SEEDS, *ALIKE_COARSE)
    rows = climbing(maps, views, seeds[kept])
    turns = turns_of(rows, views)
    kept = apart(rows[:, 2:5], turns, most, *ALIKE)
    return posed(rows[kept], turns[kept], camera, body), rows[kept, 5]


def share_maps(photo: PhotoMaps) -> None:
    """Measure what all types ask of a photo, and read the compiled loops, before copies of this process are made."""
    for size in sizes():
        for most, spread, every in ((COARSE, SPREAD, EVERY), (FINE, SPREAD_FINE, 1)):
            photo.edges(scale_for(size, most), spread, every)
            photo.cells(scale_for(size, most))
    _ = photo.usual


def scale_for(size: float, most: float) -> float:
    """The scale, in steps of half an octave, in which a size has about ``most`` pixels."""
    return float(min(1.0, 2.0 ** (np.rint(2.0 * np.log2(most / size)) / 2.0)))


def sizes() -> Floats:
    """All sizes."""
    low, high, step = SIZES
    return np.asarray(low * step ** np.arange(int(np.ceil(np.log(high / low) / np.log(step))) + 1))


def everywhere(maps: TypeMaps, views: Views) -> Floats:
    """The best of all places, rows (N, 6): a view, its turn, a size, a place in pixels of the photo, the score."""
    laid, rows = spread_over(views.turn[:, 2], LAID), []
    pad = int(np.ceil(COARSE / EVERY))
    for scale in sorted({scale_for(size, COARSE) for size in sizes()}):
        stack = maps.stack(scale, SPREAD, EVERY, pad)
        high, wide = stack.shape[1:]
        block = max(1, min(6, 1400 // wide)) * wide
        for size in (size for size in sizes() if scale_for(size, COARSE) == scale):
            offset, count = offsets(views, laid, TURNS, size * scale / EVERY, wide, high * wide)
            best, where = scanned(stack.ravel(), offset, count, pad * wide, (high - pad) * wide, block)
            kept = np.argsort(-best.ravel(), kind="stable")[:KEPT]
            which, turn = np.divmod(kept // best.shape[1], TURNS)
            place = [
                ((cell - pad) * EVERY + EVERY // 2 + 0.5) / scale - 0.5
                for cell in np.divmod(where.ravel()[kept], wide)[::-1]
            ]
            score = best.ravel()[kept] / UNIT * (size / 100.0) ** POWER
            rows.append(
                np.column_stack([laid[which], turn * (2.0 * np.pi / TURNS), np.full(len(kept), size), *place, score])
            )
    every = np.concatenate(rows)
    return np.asarray(every[np.argsort(-every[:, 5], kind="stable")[:KEPT]])


def climbing(maps: TypeMaps, views: Views, seeds: Floats) -> Floats:
    """Such rows (N, 6), each moved to where it fits best near, the best first."""
    found = [np.zeros((0, 6))]
    scales = np.array([scale_for(size, FINE) for size in seeds[:, 2]])
    for scale in np.unique(scales):
        stack, some = maps.stack(scale, SPREAD_FINE, 1), seeds[scales == scale]
        found.append(climbed(stack, views, some, scale, STEPS, ROUNDS, POWER))
    rows = np.concatenate(found)
    rows[:, 5] /= UNIT
    return np.asarray(rows[np.argsort(-rows[:, 5], kind="stable")])


def spread_over(ways: Floats, most: int) -> Indices:
    """Which of unit vectors (N, 3), at most ``most``, are spread over all: each is farthest from those before."""
    kept, near = [0], ways @ ways[0]
    while len(kept) < min(most, len(ways)):
        kept.append(int(near.argmin()))
        near = np.maximum(near, ways @ ways[kept[-1]])
    return np.array(kept)


def turns_of(rows: Floats, views: Views) -> Floats:
    """(N, 3, 3) from the object to a camera that looks along the line of sight."""
    c, s, zero = np.cos(rows[:, 1]), np.sin(rows[:, 1]), np.zeros(len(rows))
    about = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(-1, 3, 3)
    return np.asarray(about @ views.turn[rows[:, 0].astype(int)])


def posed(rows: Floats, turns: Floats, camera: Camera, body: Body) -> Floats:
    """(N, 4, 4) of rows' sizes and places, turned as ``turns`` (N, 3, 3) say about the line of sight."""
    sight = np.column_stack([camera.normalised(rows[:, 3:5]), np.ones(len(rows))])
    unit = sight / np.linalg.norm(sight, axis=1, keepdims=True)
    result = np.tile(np.eye(4), (len(rows), 1, 1))
    result[:, :3, :3] = least_turns(np.array([0.0, 0.0, 1.0]), unit) @ turns
    depth = camera.f * body.diameter / rows[:, 2]
    result[:, :3, 3] = sight * depth[:, None] - result[:, :3, :3] @ body.middle
    return result
