"""Lines across the outline of what is drawn, and across its creases, and what a photo shows along them.

* ``Lines``: N of them, each a place, the direction across and the depth there
* ``on_edges``: how far along each the nearest edge is; ``between_colours``: where its two sides are best told apart
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from geometry.arrays import Floats
from sensing.pixels.crop import Crop, clear
from sensing.pixels.drawn import Drawn
from sensing.pixels.loops import both_sides, edge_off, nearby, ridges_of, rim_of, shifted

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


def lines_at(at: Floats, across: Floats, depth: Floats, left: int, whole: int) -> Lines:
    """As ``Lines``, its arrays as compiled loops take them."""
    at, across, depth = (np.ascontiguousarray(some, float) for some in (at, across, depth))
    return Lines(at, across, depth, left, whole)


def outline_of(crop: Crop, drawn: Drawn, slack: float) -> Lines:
    """Across the outline where nothing hides it."""
    mask = drawn.mask
    smooth = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), SMOOTH)
    at, across, depth, whole = rim_of(mask, smooth, drawn.depth, crop.near, slack, RIM)
    some = slice(None, None, max(1, -(-len(at) // MOST)))
    return lines_at(at[some], across[some], depth[some], len(at), whole)


CREASED = 0.12
"""Change of the unit normal a pixel that is a crease."""


def creases_of(crop: Crop, drawn: Drawn, slack: float) -> Lines:
    """Across the creases within the outline."""
    mask = drawn.mask.astype(np.float32)
    share = np.maximum(cv2.GaussianBlur(mask, (0, 0), 1.2), 0.2)[..., None]
    smooth = cv2.GaussianBlur(drawn.normal.astype(np.float32), (0, 0), 1.2) / share
    a, b = (cv2.Sobel(smooth, cv2.CV_32F, *way) / 8.0 for way in ((1, 0), (0, 1)))
    inside = cv2.erode(drawn.mask.astype(np.uint8), np.ones((7, 7), np.uint8), borderValue=0) > 0
    at, across = ridges_of(a, b, inside & clear(crop, drawn, slack), CREASED)
    some = slice(None, None, max(1, -(-len(at) // MOST_CREASES)))
    x, y = at[some].T
    return lines_at(at[some], across[some], drawn.depth[y, x], len(at), len(at))


def on_edges(crop: Crop, lines: Lines, reach: int) -> Floats:
    """(N,) pixels along each line to the nearest edge across it, ``NOWHERE`` for none."""
    least = max(1.0, 3.0 * crop.noise * 0.39 * 0.35)
    return np.asarray(edge_off(crop.gradient, lines.at, lines.across, reach, least))


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
    steps, shifts = np.arange(-length, length + 1), np.arange(-reach, reach + 1)
    colour, *sides = both_sides(crop.colour, lines.at, lines.across, length, len(crop.palette))
    near = nearby(lines.at, OWN, NEIGHBOURS * crop.size)
    inside, outside = (_shares(near @ count, count) for count in sides)
    inner = 0.5 - 0.5 * np.tanh((steps[None, :] - shifts[:, None]) / SOFT)
    score, apart = shifted(colour, inside, outside, inner, EVERY)
    score = TEMPERED * (score - score.max(axis=1, keepdims=True))
    likely = np.exp(score)
    total = likely.sum(axis=1)
    off = (likely * shifts).sum(axis=1) / total
    variance = (likely * shifts**2).sum(axis=1) / total - off**2
    return Told(score[:, reach] - np.log(total) + np.log(len(shifts)), off, variance, apart / (2.0 * length))


def _shares(pooled: Floats, count: Floats) -> Floats:
    """(N, C) shares of the palette's colours on one side of N lines, ``pooled`` over their neighbours."""
    some = pooled + 1e-3 * count.sum(axis=0)
    return np.asarray(some / np.maximum(some.sum(axis=1, keepdims=True), 1e-9))
