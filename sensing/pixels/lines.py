"""Lines across the outline of what is drawn, and across its creases, and what a photo shows along them.

* ``Lines``: N of them, each a place, the direction across and the depth there
* ``on_edges``: how far along each the nearest edge is; ``between_colours``: where its two sides are best told apart
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints
from sensing.pixels.crop import Crop, clear
from sensing.pixels.drawn import Drawn

MOST, MOST_CREASES = 160, 120
"""Lines across an outline, and across creases, evenly chosen."""
SMOOTH = 1.5
"""Pixels, standard deviation, over which an outline's direction is taken."""
RIM = 3
"""Pixels of the photo's part at its rim without lines."""
SLACK = 0.03
"""Share of the diameter by which what stands for sure must be nearer to hide a place."""


@dataclass(frozen=True, eq=False)
class Lines:
    """``at``, ``across`` (N, 2) pixels and unit vectors, outward of an outline; ``depth`` (N,) m.

    ``left`` of ``whole``: of how many pixels of it, were nothing hidden or cut off, these are chosen.
    """

    at: Floats
    across: Floats
    depth: Floats
    left: int
    whole: int

    def __len__(self) -> int:
        return len(self.at)


def outline_of(crop: Crop, drawn: Drawn, slack: float) -> Lines:
    """Across the outline where nothing hides it."""
    mask = drawn.mask
    smooth = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), SMOOTH)
    inner = cv2.erode(mask.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), borderValue=0) > 0
    y, x = np.nonzero(mask & ~inner)
    slope = np.column_stack([cv2.Sobel(smooth, cv2.CV_32F, *way, ksize=3)[y, x] / 8.0 for way in ((1, 0), (0, 1))])
    steep = np.linalg.norm(slope, axis=1)
    across = -slope / np.maximum(steep, 1e-6)[:, None]
    off = np.clip((smooth[y, x] - 0.5) / np.maximum(steep, 1e-6), -1.0, 1.0)
    width, height = crop.shape
    good = (x >= RIM) & (y >= RIM) & (x < width - RIM) & (y < height - RIM) & (steep > 0.02)
    good &= crop.near[y, x] > drawn.depth[y, x] - slack
    at = np.column_stack([x, y]) + off[:, None] * across
    some = np.flatnonzero(good)[:: max(1, -(-int(good.sum()) // MOST))]
    return Lines(at[some], across[some], drawn.depth[y, x][some], int(good.sum()), len(x))


CREASED = 0.12
"""Change of the unit normal a pixel that is a crease."""


def creases_of(crop: Crop, drawn: Drawn, slack: float) -> Lines:
    """Across the creases within the outline."""
    mask = drawn.mask.astype(np.float32)
    share = np.maximum(cv2.GaussianBlur(mask, (0, 0), 1.2), 0.2)[..., None]
    smooth = cv2.GaussianBlur(drawn.normal.astype(np.float32), (0, 0), 1.2) / share
    a, b = (cv2.Sobel(smooth, cv2.CV_32F, *way) / 8.0 for way in ((1, 0), (0, 1)))
    xx, xy, yy = (a * a).sum(axis=2), (a * b).sum(axis=2), (b * b).sum(axis=2)
    bend, turn = np.sqrt(xx + yy), 0.5 * np.arctan2(2.0 * xy, xx - yy)
    inside = cv2.erode(drawn.mask.astype(np.uint8), np.ones((7, 7), np.uint8), borderValue=0) > 0
    y, x = np.nonzero(inside & clear(crop, drawn, slack) & (bend > CREASED))
    across = np.column_stack([np.cos(turn[y, x]), np.sin(turn[y, x])])
    step = np.rint(across).astype(int)
    width, height = crop.shape
    ahead, behind = (
        bend[np.clip(y + sign * step[:, 1], 0, height - 1), np.clip(x + sign * step[:, 0], 0, width - 1)]
        for sign in (1, -1)
    )
    ridge = np.flatnonzero((bend[y, x] >= ahead) & (bend[y, x] > behind))
    some = ridge[:: max(1, -(-len(ridge) // MOST_CREASES))]
    return Lines(
        np.column_stack([x, y])[some].astype(float), across[some], drawn.depth[y, x][some], len(ridge), len(ridge)
    )


ACROSS = 0.8
"""Least share of the gradient that is along the line: within 36°."""
NOWHERE = 99.0


def on_edges(crop: Crop, lines: Lines, reach: int) -> tuple[Floats, Floats]:
    """(N,) pixels along each line to the nearest edge across it, ``NOWHERE`` for none; (N,) how steep it is."""
    steps = np.arange(-reach - 1, reach + 2)
    least = max(1.0, 3.0 * crop.noise * 0.39 * 0.35)
    at = lines.at[:, None] + steps[None, :, None] * lines.across[:, None]
    slope = sampled(crop.gradient, at)
    along, steep = np.abs((slope * lines.across[:, None]).sum(axis=2)), np.linalg.norm(slope, axis=2)
    rise = np.where(along > ACROSS * steep, along, 0.0)
    here, before, after = rise[:, 1:-1], rise[:, :-2], rise[:, 2:]
    peak = (here > least) & (here >= before) & (here >= after)
    far = np.where(peak, np.abs(steps[1:-1]), np.inf)
    best = far.argmin(axis=1)
    row = np.arange(len(lines))
    bend = before[row, best] - 2.0 * here[row, best] + after[row, best]
    off = steps[1:-1][best] + np.where(bend < -1e-6, 0.5 * (before - after)[row, best] / np.minimum(bend, -1e-6), 0.0)
    found = np.isfinite(far[row, best])
    return np.where(found, off, NOWHERE), np.where(found, here[row, best], 0.0)


def sampled(values: NDArray[np.float32], at: Floats) -> Floats:
    """(..., C) of (h, w, C) between its pixels at (..., 2); 0 outside."""
    height, width = values.shape[:2]
    x, y = np.floor(at[..., 0]), np.floor(at[..., 1])
    inside = (x >= 0) & (y >= 0) & (x < width - 1) & (y < height - 1)
    i, j = (np.where(inside, side, 0).astype(np.intp) for side in (x, y))
    a, b = ((at[..., axis] - side)[..., None] for axis, side in ((0, x), (1, y)))
    upper = values[j, i] * (1 - a) + values[j, i + 1] * a
    lower = values[j + 1, i] * (1 - a) + values[j + 1, i + 1] * a
    return np.asarray(np.where(inside[..., None], upper * (1 - b) + lower * b, 0.0))


NEIGHBOURS = 0.25
"""Share of the object's size over which the colours of the two sides are pooled (standard deviation)."""
OWN = 6.5
"""Squared pixels: lines nearer than this tell nothing of each other, for they share their pixels."""
SOFT = 1.2
"""Pixels over which an outline is blurred."""
TEMPERED = 0.5
"""A pixel of a line counts for so much of an independent one."""
EVERY = 0.004
"""Share of each colour that either side may have besides."""


class Told(NamedTuple):
    """Of N lines: ``here``, the logarithm of how much likelier the outline is here than anywhere in reach.

    ``off``, ``variance`` (N,) of where it is, pixels; ``apart`` (N,) how well the two sides are told apart, nats a
    pixel.
    """

    here: Floats
    off: Floats
    variance: Floats
    apart: Floats


def between_colours(crop: Crop, lines: Lines, length: int, reach: int) -> Told:
    """Where along each line, ``length`` px to either side, the colours inside give way to those outside."""
    steps = np.arange(-length, length + 1)
    width, height = crop.shape
    at = np.rint(lines.at[:, None] + steps[None, :, None] * lines.across[:, None]).astype(np.intp)
    colour = crop.colour[np.clip(at[..., 1], 0, height - 1), np.clip(at[..., 0], 0, width - 1)]
    kernel = _pooled(lines, crop.size)
    inside, outside = (_shares(colour[:, side], len(crop.palette), kernel) for side in (steps < -1, steps > 1))
    a, b = (np.take_along_axis(some, colour, axis=1) + EVERY for some in (inside, outside))
    share = a / (a + b)
    sign = np.sign(steps)
    apart = (np.where(sign < 0, np.log(2.0 * share), np.log(2.0 - 2.0 * share)) * (sign != 0)).sum(axis=1)
    shifts = np.arange(-reach, reach + 1)
    inner = 0.5 - 0.5 * np.tanh((steps[None, :] - shifts[:, None]) / SOFT)
    mixed = share[:, None, :] * (2.0 * inner - 1.0) + (1.0 - inner)
    score = TEMPERED * np.log(np.maximum(mixed, 1e-12)).sum(axis=2)
    score -= score.max(axis=1, keepdims=True)
    likely = np.exp(score)
    total = likely.sum(axis=1)
    off = (likely * shifts).sum(axis=1) / total
    variance = (likely * shifts**2).sum(axis=1) / total - off**2
    return Told(score[:, reach] - np.log(total) + np.log(len(shifts)), off, variance, apart / (2.0 * length))


def _pooled(lines: Lines, size: float) -> Floats:
    """(N, N) how much each line tells of the colours at each other."""
    square = ((lines.at[:, None] - lines.at[None]) ** 2).sum(axis=2)
    return np.asarray(np.where(square < OWN, 0.0, np.exp(-square / (2.0 * (NEIGHBOURS * size) ** 2))))


def _shares(colour: Ints, colours: int, kernel: Floats) -> Floats:
    """(N, C) shares of the palette's colours on one side of N lines, pooled."""
    row = np.repeat(np.arange(len(colour)), colour.shape[1])
    count = np.bincount(row * colours + colour.ravel(), minlength=len(colour) * colours).reshape(-1, colours)
    pooled = kernel @ count + 1e-3 * count.sum(axis=0)
    return np.asarray(pooled / np.maximum(pooled.sum(axis=1, keepdims=True), 1e-9))
