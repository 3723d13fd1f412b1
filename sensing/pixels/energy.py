"""How well a pose's pixels fit: edges along its outline, colours on its two sides, and its print (formalism §9.10).

The parts are means over what each has, times how many independent measurements that is worth (``WORTH``), so that they
are one logarithm of a likelihood, about.
"""

from typing import NamedTuple

import cv2
import numpy as np

from geometry.arrays import Floats
from sensing.pixels.blocks import Blocks, blocks_of, smoothed
from sensing.pixels.crop import Crop, clear
from sensing.pixels.drawn import Drawn, Paint
from sensing.pixels.lines import SLACK, Lines, between_colours, creases_of, lines_at, on_edges, outline_of
from sensing.pixels.loops import NOWHERE

EDGES, PRINT, REGION = 5.0, 27.0, 3.0
"""What the mean over an outline of edges, the print of a whole surface, and the mean over an outline of colours are
worth, in independent measurements."""
FEWEST_LINES, FEWEST_PIXELS = 12, 60
"""Of fewer nothing is said."""
LOST = 0.1
"""Share of the lines across an outline that say nothing of it."""
SHARP, CLUTTER, MISSED = 1.1, 0.25, -0.45
"""An edge is off its place by so many pixels (standard deviation); share of edges that are another's; what it tells
that there is none."""
NEAR_IT = 3.0
"""Pixels within which an edge is the outline's."""
WHOLE = 0.4
"""Share of the square over its larger side that a body covers: all of its print is that of so many pixels."""


ODDS = -11.2, 10.0, 0.4, 31.1, 5.4
"""What is told of a fit that is not there at all, by a unit of edges, of region, of print up to ``FIRM``, and of print
beyond it, of what shows print (``python benchmarks/pixel_odds.py KB DATASET``)."""
PLAIN = -1.0, 0.2, 6.2, 18.7, 0.0, 6.9, 3.4
"""The same of what is plain: of a fit that is not there at all, by a unit of edges, of region, of print up to ``FIRM``,
of creases, of ``quiet`` and of ``length``."""
PRINTED = 0.2, 0.5
"""``shown`` up to which something is plain, and from which it shows print."""
FIRM = 0.3
"""Print that is hardly ever met by chance alone; with an outline as well, the object is there."""
HALF = 0.5
"""Share of its outline in sight from which it owes all of an outline; of what is less in sight less is expected, and
of what is wholly hidden nothing is told."""
LEAST = -12.0
"""So much is believed against an object at most: pixels are not independent."""
LONG, USUAL = 250.0, 0.15
"""Pixels of an outline from which it is not short; standard deviation of what edges tell by chance, up to which nothing
is said: where nothing is, it is quiet, too."""
FEWEST_CREASES, FEWEST_BESIDE = 6, 4
"""Lines across creases, and outlines beside, of fewer of which nothing is said."""
_BESIDE = np.array(
    [
        [radius * np.cos(angle), radius * np.sin(angle)]
        for radius in (0.15, 0.25, 0.35)
        for angle in np.arange(8) * np.pi / 4.0
    ]
)
"""(24, 2) shares of the object's size by which an outline is moved to see what chance tells of it."""


class Fit(NamedTuple):
    """Of one pose: ``edges``, ``region`` (means, nats a line), ``print_`` (nats) and ``correlation`` of its print.

    ``visible``: share of its outline that is in the photo with nothing before it; ``shown``: of what is drawn, 0 to 1,
    that is print above noise. What ``odds`` are of besides: ``creases`` (mean, nats a line, of few less), ``quiet``
    (0, or less where outlines beside this one differ by chance in their edges, nats) and ``length`` of it (nats).
    ``inexact``: the root mean square by which edges are off the outline, as a share of its size.
    """

    edges: float
    region: float
    print_: float
    correlation: float
    visible: float
    shown: float = 1.0
    creases: float = 0.0
    quiet: float = 0.0
    length: float = 0.0
    inexact: float = 0.0

    @property
    def score(self) -> float:
        """The logarithm of a likelihood, about."""
        return EDGES * self.edges + PRINT * self.print_ + REGION * self.region

    @property
    def odds(self) -> float:
        """Logarithm of how much likelier such a fit (of ``whole``) is of an object that is there than of none."""
        share = printed(self)
        both = share * np.dot(ODDS, self.told), (1.0 - share) * np.dot(PLAIN, self.told_plainly)
        return max(LEAST, float(sum(both)))

    @property
    def told(self) -> tuple[float, ...]:
        """(5,) what the weights ``ODDS`` are of."""
        firm = min(self.print_, FIRM)
        return self.owed, self.visible * self.edges, self.visible * self.region, firm, self.print_ - firm

    @property
    def told_plainly(self) -> tuple[float, ...]:
        """(7,) what the weights ``PLAIN`` are of."""
        lines = self.visible * self.edges, self.visible * self.region
        beside = self.visible * self.creases, self.owed * self.quiet, self.owed * self.length
        return self.owed, *lines, min(self.print_, FIRM), *beside

    @property
    def owed(self) -> float:
        """How much of an outline is owed by the share in sight."""
        return min(1.0, self.visible / HALF)


def printed(fit: Fit) -> float:
    """How far a fit is judged as one of what shows print, 0 to 1."""
    return float(np.clip((fit.shown - PRINTED[0]) / (PRINTED[1] - PRINTED[0]), 0.0, 1.0))


NO_FIT = Fit(-9.0, -9.0, 0.0, 0.0, 0.0)


def spans(crop: Crop) -> tuple[int, int]:
    """Pixels to either side of an outline in which colours are compared, and in which it is looked for."""
    return int(np.clip(round(0.085 * crop.size), 5, 11)), int(np.clip(round(0.055 * crop.size), 3, 7))


def edges_told(off: Floats, reach: int) -> Floats:
    """(N,) logarithm of how much likelier the nearest edges are of an outline here than of clutter."""
    even = 1.0 / (2 * reach + 1)
    bell = np.exp(-0.5 * (off / SHARP) ** 2) / (SHARP * np.sqrt(2.0 * np.pi))
    return np.where(off < NOWHERE, np.log(((1.0 - CLUTTER) * bell + CLUTTER * even) / even), MISSED)


def spread_of(off: Floats) -> float:
    """Root mean square, pixels, by which the edges that are an outline's are off it; ``NEAR_IT`` where none is."""
    near = off[np.abs(off) <= NEAR_IT]
    return float(np.sqrt(np.mean(near**2))) if len(near) else NEAR_IT


def fit_of(crop: Crop, paint: Paint, pose: Floats, *, whole: bool = False) -> Fit:
    """How well a pose (4, 4) fits; ``whole``: with all that its ``odds`` are of, which its ``score`` does not need."""
    drawn = paint.drawn(pose, crop.K, crop.shape)
    slack = SLACK * paint.diameter
    lines = outline_of(crop, drawn, slack)
    if len(lines) < FEWEST_LINES or int(drawn.mask.sum()) < FEWEST_PIXELS:
        return NO_FIT
    length, reach = spans(crop)
    told = between_colours(crop, lines, length, reach)
    region = float(np.log((1.0 - LOST) * np.exp(told.here) + LOST).mean())
    off = on_edges(crop, lines, reach)
    fine = squares_of(crop, drawn, slack, max(5, round(crop.size / 10.0)))
    worth = 12.0 * fine.explained / (WHOLE * crop.size**2)
    edges, visible = float(edges_told(off, reach).mean()), visible_share(lines)
    fit = Fit(edges, region, worth, fine.correlation, visible, fine.shown, inexact=spread_of(off) / crop.size)
    if not whole:
        return fit
    creases = creases_of(crop, drawn, slack)
    found = edges_told(on_edges(crop, creases, reach), reach).mean() if len(creases) >= FEWEST_CREASES else 0.0
    few = min(1.0, creases.left / lines.left)
    return fit._replace(
        creases=float(found * few),
        quiet=min(0.0, -float(np.log(max(by_chance(crop, lines, reach), USUAL) / USUAL))),
        length=min(0.0, float(np.log(lines.left / LONG))),
    )


def by_chance(crop: Crop, lines: Lines, reach: int) -> float:
    """Standard deviation of what edges tell of outlines like this one beside it."""
    at = lines.at[::2] + crop.size * _BESIDE[:, None]
    within = ((at > reach + 2) & (at < np.array(crop.shape) - reach - 3)).all(axis=2)
    many = len(_BESIDE)
    moved = lines_at(at.reshape(-1, 2), np.tile(lines.across[::2], (many, 1)), np.tile(lines.depth[::2], many), 0, 0)
    told = edges_told(on_edges(crop, moved, reach), reach).reshape(within.shape)
    count = within.sum(axis=1)
    enough = count >= FEWEST_LINES / 2
    if enough.sum() < FEWEST_BESIDE:
        return USUAL
    means = (told * within).sum(axis=1)[enough] / count[enough]
    return float(means.std())


def squares_of(crop: Crop, drawn: Drawn, slack: float, side: int, rim: int = 3) -> Blocks:
    """The squares of its visible surface, ``rim`` pixels wide kernels away from its outline."""
    inner = cv2.erode(drawn.mask.astype(np.uint8), np.ones((rim, rim), np.uint8), borderValue=0) > 0
    return blocks_of(crop, smoothed(crop, drawn), inner & clear(crop, drawn, slack), side)


def visible_share(lines: Lines) -> float:
    """Of the drawn outline, by the lines that are left of it."""
    return lines.left / max(lines.whole, 1)


def choice(fits: list[Fit]) -> tuple[int, list[float]]:
    """Which of several poses fits best, and their scores; print counts as far as it is trusted."""
    trust = trusted(fits)
    scores = [EDGES * fit.edges + trust * PRINT * fit.print_ + REGION * fit.region for fit in fits]
    return int(np.argmax(scores)), scores


def trusted(fits: list[Fit]) -> float:
    """How far print counts, 0 to 1: as any pose's correlates; where none does, it is not the object's."""
    return float(np.clip((max(fit.correlation for fit in fits) - 0.2) / 0.3, 0.0, 1.0))
