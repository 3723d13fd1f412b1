"""Regions of one colour or brightness that stand out.

What a thing without print shows, a yellow bottle, a red face of a cube.

A region is found where it hardly changes when the threshold does (Matas et al., Robust wide baseline stereo from
maximally stable extremal regions, 2002; OpenCV's MSER), in brightness and in the ratios of colours, which shading does
not change. It is described by its shape alone, so that what lies behind counts for nothing, and by its colour.

* ``regions(image)``: as ``Keypoints``, one for each direction of a region
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Ints, Mask
from sensing.detectors.keypoints import WIDTH, Keypoints, grey_of, holds, is_grey, ratios, sift_at

MOST, LEAST_REGIONS, EVERY = 400, 60, 768
"""Regions of one image at most, those that stand out most: one in so many pixels, but at least and at most so many."""
HALF = 2
"""The image is looked at so many times smaller: a region's place is a mean over its pixels, and does not need more."""
SMOOTH = 0.75
"""Pixels of the smaller image, standard deviation: noise below this size makes no region."""
COARSE = 4
"""Levels that count as one: thresholds nearer to one another give the same regions again."""
STABLE = ((8, 0.7), (3, 0.35), (1, 0.15))
"""A region is stable where over so many thresholds its area changes by less than this share: many for what is plain,
few for what is faint."""
SAME = (1.0, 0.12)
"""Its pixels, and logarithm of the radius: two regions that differ by less are one, of which that stable over the most
levels is kept."""
AREA = (16, 10_000)
"""Smallest and largest region in its pixels. What reaches the image's border may go on beyond it, and is left out."""
RADIUS, TILE = 6.0, 42
"""Pixels to which a region's radius is scaled, and of the square into which it is then drawn."""
SIZE = 5.0 * RADIUS / 6.0
"""Diameter of the keypoint that describes it there: SIFT sees six times as much, five radii."""
BINS, PEAK, TURNS = 36, 0.8, 4
"""Directions of the outline's normals are counted in so many bins; those nearly as frequent as the first are the
region's, at most so many."""
CONTRAST = 1e-3
"""Response for one level by which a region differs from what is around it: 15 levels count as half sure, as SIFT's
typical response does."""


class _Region(NamedTuple):
    """``channel``, which of the image's it was found in; over how many thresholds it is stable.

    Its pixels (P, 2), the corner and size of the box of them, their middle, its radius.
    """

    channel: int
    step: int
    points: NDArray[np.int32]
    low: Ints
    size: Ints
    middle: Floats
    radius: float


def regions(image: Bytes, most: int = MOST, where: Mask | None = None) -> Keypoints:
    """Of an (H, W) or (H, W, 3) uint8 image, blue first.

    Those that stand out most first, each once for each of its directions; of them those on whose middle's pixel
    ``where`` (H, W) holds.

    ``scale`` is the diameter of a circle as large; ``descriptors`` are (N, 138), or (N, 128) of an image without
    colours.
    """
    channels, coloured = _channels(image), not is_grey(image)
    factor = np.array([image.shape[1], image.shape[0]]) / channels[0].shape[::-1]
    most = min(most, max(LEAST_REGIONS, image.shape[0] * image.shape[1] // EVERY))
    found = _apart([region for number, channel in enumerate(channels) for region in _stable(number, channel)])
    contrast = np.array([_contrast(region, channels[region.channel]) for region in found])
    order = sorted(
        range(len(found)), key=lambda i: (-contrast[i] * found[i].radius, *found[i].middle.tolist(), found[i].radius)
    )[:most]
    if where is not None and order:
        there = holds(where, (np.array([found[i].middle for i in order]) + 0.5) * factor - 0.5)
        order = [i for i, so in zip(order, there.tolist(), strict=True) if so]
    chosen = [found[i] for i in order]
    tiles = np.array([_tile(region) for region in chosen]).reshape(-1, TILE, TILE)
    owner, angle = _directions(tiles)
    shapes = _described(tiles, owner, angle)
    if coloured:
        colour = np.array([_colour(region, channels) for region in chosen], np.uint8).reshape(len(chosen), WIDTH)
        shapes = np.column_stack([shapes, colour[owner]])
    return Keypoints(
        ((np.array([region.middle for region in chosen]).reshape(-1, 2) + 0.5) * factor - 0.5)[owner],
        angle,
        np.array([2.0 * region.radius for region in chosen])[owner] * float(np.sqrt(factor.prod())),
        CONTRAST * contrast[order][owner] if order else np.zeros(0),
        shapes,
    )


def _channels(image: Bytes) -> list[Bytes]:
    """(h, w) levels each, of the smaller image.

    Brightness, and of an image with colours red against green, blue against green.
    """
    size = tuple(-(-side // HALF) for side in image.shape[1::-1])
    small = np.asarray(
        cv2.GaussianBlur(cv2.resize(image, size, interpolation=cv2.INTER_AREA), (0, 0), SMOOTH), np.uint8
    )
    if is_grey(image):
        return [grey_of(small)]
    against_green = ratios(small.astype(np.float32))
    return [grey_of(small), *(np.ascontiguousarray(against_green[..., i]) for i in (0, 1))]


def _stable(number: int, channel: Bytes) -> list[_Region]:
    """The stable regions of one channel."""
    if min(channel.shape) < 3:
        return []
    limit, levels = np.array(channel.shape[::-1]), channel // COARSE
    found = []
    for step, change in STABLE:
        listed, boxes = cv2.MSER.create(step, *AREA, change, 0.0).detectRegions(levels)
        corners = np.asarray(boxes, int).reshape(-1, 4)
        whole = (corners[:, :2] > 1).all(axis=1) & (corners[:, :2] + corners[:, 2:] < limit - 1).all(
            axis=1
        )  # OpenCV keeps off the outermost pixels
        found += [
            (step, np.asarray(listed[i], np.int32), corners[i, :2], corners[i, 2:])
            for i in np.flatnonzero(whole).tolist()
        ]
    return [
        _Region(number, step, points, low, size, _mean(points), math.sqrt(len(points) / math.pi))
        for step, points, low, size in found
    ]


def _mean(values: NDArray[Any]) -> Floats:
    """Mean over the first axis; numpy's own takes thrice as long of few values."""
    return np.asarray(np.add.reduce(values, axis=0, dtype=np.float64) / len(values))


def _apart(found: list[_Region]) -> list[_Region]:
    """No two that are nearly the same; of those the most stable, then the largest."""
    if not found:
        return []
    from scipy.spatial import cKDTree

    ranked = sorted(found, key=lambda region: (-region.step, -region.radius, *region.middle.tolist()))
    size = np.log([region.radius for region in ranked])
    near = cKDTree([region.middle for region in ranked]).query_ball_point([region.middle for region in ranked], SAME[0])
    left, kept = np.ones(len(ranked), bool), []
    for i, others in enumerate(near):
        if left[i]:
            kept.append(ranked[i])
            left[[j for j in others if abs(size[j] - size[i]) < SAME[1]]] = False
    return kept


def _contrast(region: _Region, channel: Bytes) -> float:
    """Levels by which a region differs from what else is in the box around it."""
    (left, top), (width, height) = region.low.tolist(), region.size.tolist()
    whole = channel[max(top - 2, 0) : top + height + 2, max(left - 2, 0) : left + width + 2]
    inside = float(channel[region.points[:, 1], region.points[:, 0]].sum())
    return abs(inside / len(region.points) - (float(whole.sum()) - inside) / max(whole.size - len(region.points), 1))


def _colour(region: _Region, channels: Sequence[Bytes]) -> list[int]:
    """Its mean colour, as if all cells of a keypoint had it."""
    x, y = region.points.T
    return [round(float(_mean(channel[y, x]))) for channel in channels[1:]] * (WIDTH // 2)


def _tile(region: _Region) -> NDArray[np.float32]:
    """(TILE, TILE) the region's shape, 255 within and 0 without, its middle in the middle."""
    drawn = np.zeros(region.size[::-1], np.float32)
    x, y = (region.points - region.low).T
    drawn[y, x] = 255.0
    factor = RADIUS / region.radius
    if factor < 1.0:
        reach = int(np.ceil(1.5 / factor))
        drawn = np.asarray(cv2.GaussianBlur(np.pad(drawn, reach), (0, 0), 0.5 / factor), np.float32)
    else:
        reach = 0
    middle = (TILE - 1) / 2.0 - factor * (region.middle - region.low + reach)
    placed = np.array([[factor, 0.0, middle[0]], [0.0, factor, middle[1]]])
    return np.asarray(cv2.warpAffine(drawn, placed, (TILE, TILE), flags=cv2.INTER_LINEAR), np.float32)


def _directions(tiles: NDArray[np.float32]) -> tuple[NDArray[np.intp], Floats]:
    """Of (R, TILE, TILE) shapes, the directions (N,) that their outlines face most, and whose they are (N,).

    From within, outwards reversed.
    """
    slopes = [np.asarray(slope) for slope in np.gradient(tiles, axis=(1, 2))] if len(tiles) else [tiles, tiles]
    number, y, x = np.nonzero(np.maximum(np.abs(slopes[0]), np.abs(slopes[1])) > 0.0)
    down, right = (np.asarray(slope[number, y, x], np.float64) for slope in slopes)
    cell = np.floor(np.arctan2(down, right) % (2.0 * np.pi) * (BINS / (2.0 * np.pi))).astype(np.intp) % BINS
    counts = np.bincount(number * BINS + cell, np.hypot(down, right), len(tiles) * BINS).reshape(-1, BINS)
    for _ in range(2):
        counts = np.asarray((np.roll(counts, 1, axis=1) + counts + np.roll(counts, -1, axis=1)) / 3.0, np.float64)
    before, after = np.roll(counts, 1, axis=1), np.roll(counts, -1, axis=1)
    peak = (counts > before) & (counts >= after) & (counts >= PEAK * counts.max(axis=1, initial=0.0, keepdims=True))
    rank = np.argsort(np.argsort(np.where(peak, -counts, 1.0), axis=1, kind="stable"), axis=1, kind="stable")
    owner, place = np.nonzero(peak & (rank < TURNS))
    bend = np.minimum(before + after - 2.0 * counts, -1e-9)[owner, place]
    shift = 0.5 * (before - after)[owner, place] / bend
    return owner, np.asarray((place + 0.5 + np.clip(shift, -0.5, 0.5)) * (2.0 * np.pi / BINS) % (2.0 * np.pi))


def _described(tiles: NDArray[np.float32], owner: NDArray[np.intp], angle: Floats) -> Bytes:
    """(N, 128) SIFT of the shapes, each turned by its angle; all shapes are laid out in one picture."""
    if not len(owner):
        return np.zeros((0, 128), np.uint8)
    across = int(np.ceil(np.sqrt(len(tiles))))
    down = -(-len(tiles) // across)
    sheet = np.zeros((down * across, TILE, TILE), np.uint8)
    sheet[: len(tiles)] = np.rint(tiles)
    picture = sheet.reshape(down, across, TILE, TILE).swapaxes(1, 2).reshape(down * TILE, across * TILE)
    row, column = np.divmod(owner, across)
    uv = np.column_stack([column, row]) * TILE + (TILE - 1) / 2.0
    return sift_at(
        np.ascontiguousarray(picture), uv, angle, np.full(len(owner), SIZE), np.zeros(len(owner))
    ).descriptors
