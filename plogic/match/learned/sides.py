"""Which sides of edges a pose's own are (D8), and how rare that is where they are.

Where along an edge a side is reported is arbitrary. So a side is that of an expected feature if it lies on its line,
near its place, faces as it does and has its colours; what is off along the line says nothing. Edges are everywhere:
what would look as right in the neighbourhood, were it in place, is counted, and a side is evidence for as much as it is
rarer than that. A checkered floor shows the sides of a square's edges at every second tile: what would be found as well
were the whole hypothesis moved to other places nearby is the pattern of the image, not an object in it.

* ``SidePairs``: N pairs of a place and a datum, with how far off each is; ``facing``: which sides face alike and are of
  like colours, wherever they are
* ``SideMatches``: N features and the sides that are theirs
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.data import Columns, Data
from plogic.match.gamma.grid import screen_angle, wrapped
from plogic.match.gamma.side_looks import colours_off, looks_fit
from plogic.match.judged.evidence import clutter_density, density

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.learned.learned_models import LearnedIndex


AROUND = 32.0
"""Pixels around a place within which what looks as right is counted."""
TURNED = 0.34
"""Radians by which what looks right may face another way: less than a part of the grid's circle."""
FEW = 0.5
"""What is counted besides, since nowhere there can be none."""


@dataclass(frozen=True)
class SidePairs(Columns):
    """``place``, ``datum`` (N,) and how far off each datum is.

    ``turned`` (N,) radians by which it faces another way; ``off``, ``along`` (N,) pixels across the line and along it;
    ``colours`` (N,) a share, below 1 (``side_looks``).
    """

    place: Indices
    datum: Indices
    turned: Floats
    off: Floats
    along: Floats
    colours: NDArray[np.float32]

    def usual(self, reach: Floats | float, count: int) -> Floats:
        """(count,) sides per pixel² that look right around each place, within ``reach`` (count,) px of its line."""
        within = np.broadcast_to(np.asarray(reach, float), count)
        clutter = np.abs(self.off) > within[self.place]
        area = np.pi * AROUND**2 - 4.0 * AROUND * np.minimum(within, AROUND / 2.0)
        return np.asarray((np.bincount(self.place[clutter], minlength=count) + FEW) / area)


def side_pairs(index: LearnedIndex, data: Data, lobes: Indices, uv: Floats, angle: Floats) -> SidePairs:
    """Of appearances ``lobes`` (Q,) that a pose puts at uv (Q, 2) pixels, facing angle (Q,) radians."""
    place, datum = data.sides.near(uv, AROUND, angle)
    right, down = (data.uv[:, axis][datum] - uv[:, axis][place] for axis in (0, 1))
    near = right * right + down * down < AROUND**2
    place, datum, right, down = place[near], datum[near], right[near], down[near]
    alike, turned, colours = facing(index.looks[lobes], angle, data, place, datum)
    place, datum, right, down = place[alike], datum[alike], right[alike], down[alike]
    cos, sin = np.cos(angle)[place], np.sin(angle)[place]
    return SidePairs(place, datum, turned, right * cos + down * sin, down * cos - right * sin, colours)


def facing(
    looks: NDArray[np.float32], angle: Floats, data: Data, side: Indices, datum: Indices
) -> tuple[Indices, Floats, NDArray[np.float32]]:
    """Of N pairs of sides, of looks (Q, 6) and facing angle (Q,) radians, the M that face alike in like colours.

    Returns which (M,) they are, by how much they face another way, and how far off their colours are.
    """
    turned = wrapped(data.angle[datum] - angle[side])
    alike = np.flatnonzero(np.abs(turned) < TURNED)
    colours = colours_off(looks[side[alike]], data.looks[datum[alike]], coloured=data.coloured)
    right = colours < 1.0
    alike = alike[right]
    return alike, turned[alike], colours[right]


SOME = 20
"""Sides that are looked for elsewhere, evenly chosen."""
AWAY = (0.5, 2.0)
"""How far elsewhere is, in diagonals of the sides' own rectangle."""
CELL = 5.0
"""Pixels: a side is found elsewhere that is within a square of two such cells."""
OTHERS = 3
"""So many other places must show it: one or two more objects of one type may stand beside it."""


def share_elsewhere(uv: Floats, angle: Floats, looks: NDArray[np.float32], data: Data) -> float:
    """The share of sides at uv (N, 2) px, facing angle (N,), of looks (N, 6), found at each of ``OTHERS`` places."""
    some = np.unique(np.linspace(0, len(uv) - 1, SOME).round().astype(np.intp)) if len(uv) else np.zeros(0, np.intp)
    diagonal = float(np.linalg.norm(np.ptp(uv, axis=0))) if len(uv) else 0.0
    if len(some) < 2 or diagonal < 2.0 * CELL:
        return 0.0
    side, shift = _shifts(uv[some], angle[some], looks[some], data)
    away = np.abs(shift).max(axis=1) <= AWAY[1] * diagonal
    away &= np.hypot(*shift.T) >= AWAY[0] * diagonal
    side, shift = side[away], shift[away]
    reach = int(AWAY[1] * diagonal / CELL) + 2
    wide = 2 * reach + 2
    column, row = (np.floor(shift / CELL).astype(np.intp) + reach).T
    squares = np.concatenate([(row - down) * wide + column - across for down in (0, 1) for across in (0, 1)])
    there = np.zeros((wide * wide, len(some)), bool)
    there[squares, np.tile(side, 4)] = True
    count = there.sum(axis=1).reshape(wide, wide)
    apart = max(1, int(AWAY[0] * diagonal / CELL))
    for _ in range(OTHERS - 1):
        y, x = np.unravel_index(int(count.argmax()), count.shape)
        count[max(0, y - apart) : y + apart + 1, max(0, x - apart) : x + apart + 1] = 0
    return float(count.max() / len(some))


def _shifts(uv: Floats, angle: Floats, looks: NDArray[np.float32], data: Data) -> tuple[Indices, Floats]:
    """Of all pairs of a side and a datum that looks like it, wherever it is.

    The side's number, and how far it is to the datum, pixels.
    """
    side, datum = data.sides.facing(angle)
    alike = facing(looks, angle, data, side, datum)[0]
    return side[alike], data.uv[datum[alike]] - uv[side[alike]]


ALONG = 4.0
"""Pixels along its line within which a side is an expected feature's."""
ORDERED = 0.7
"""Least share of the sides found that is found elsewhere as well, for the image to be a pattern of them."""
FEW_SIDES, MANY = 6, 0.2
"""Of fewer sides found, or a smaller share of those expected, no pattern is sought."""
TURNS, WILD = 0.12, 0.1
"""Standard deviation of how a right side faces, radians, and the share of what is right that faces any way that may be
right."""
NEARER = 1.5
"""Pixels (standard deviation): of several sides that might be a feature's, that is taken which is rarer and nearer to
its line."""


@dataclass(frozen=True)
class SideMatches:
    """``feature`` (N,), ``datum`` (N,); ``off`` (N,) pixels across the line; ``across`` (N, 2) unit vector there.

    ``rare`` (N,).

    ``pattern``: the share of them that is found at several other places nearby as well (``patterns``), 0 where that is
    less than ``ORDERED``. ``rare``: per pixel along its line and across it, how much likelier a side that faces so is
    as this feature's than as clutter's, for a certain hit, density across its line aside.
    """

    feature: Indices
    datum: Indices
    off: Floats
    across: Floats
    rare: Floats
    pattern: float


def side_matches(
    index: LearnedIndex, posed: Hypothesis, data: Data, lobes: Indices, free: Mask, reach: Floats
) -> SideMatches:
    """Of the appearances ``lobes``, which hold the viewpoint, those of sides in the image.

    Of data that are ``free`` (A,).

    ``reach`` (F,) pixels across. One side a feature, one feature a side.
    """
    feature = index.cloud.feature[lobes]
    angle = screen_angle(index.cloud.up[lobes] @ posed.camera_from_object[:3, :3].T, posed.at[feature])
    inward = np.column_stack([np.cos(angle), np.sin(angle)])
    pairs, within = side_pairs(index, data, lobes, posed.uv[feature], angle), reach[feature]
    pairs = pairs.take(free[pairs.datum])
    usual = pairs.usual(within, len(lobes))
    mine = pairs.take((np.abs(pairs.off) <= within[pairs.place]) & (np.abs(pairs.along) <= ALONG))
    place, datum = mine.place, mine.datum
    rare = (
        _facing(mine.turned)
        * looks_fit(index.looks[lobes[place]], data.looks[datum], mine.colours, data.contrasts)
        / (2.0 * ALONG)
        / usual[place]
    )
    chosen = _one_to_one(feature[place], datum, np.log(rare) - 0.5 * (mine.off / NEARER) ** 2)
    of = place[chosen]
    many = len(of) >= max(FEW_SIDES, MANY * len(np.unique(feature)))
    pattern = share_elsewhere(posed.uv[feature[of]], angle[of], index.looks[lobes[of]], data) if many else 0.0
    return SideMatches(
        feature[of], datum[chosen], mine.off[chosen], inward[of], rare[chosen], pattern if pattern >= ORDERED else 0.0
    )


def _facing(turned: Floats) -> Floats:
    """(N,) how much likelier a right side faces ``turned`` radians another way than any side that may be right."""
    bell = np.exp(-0.5 * (turned / TURNS) ** 2) / (np.sqrt(2.0 * np.pi) * TURNS)
    return np.asarray((1.0 - WILD) * bell * 2.0 * TURNED + WILD)


def _one_to_one(feature: Indices, datum: Indices, worth: Floats) -> Indices:
    """Which of N pairs are taken: again and again those that are the best left of their feature and of their datum."""
    left = np.lexsort((datum, feature, -worth))
    chosen = []
    while len(left):
        first = np.zeros(len(left), bool)
        first[
            np.intersect1d(np.unique(feature[left], return_index=True)[1], np.unique(datum[left], return_index=True)[1])
        ] = True
        chosen.append(left[first])
        left = left[~np.isin(feature[left], feature[left[first]]) & ~np.isin(datum[left], datum[left[first]])]
    return np.concatenate([*chosen, np.zeros(0, np.intp)])


def side_likeness(found: SideMatches, sigma: Floats, data: Data, kb: KnowledgeBase) -> Floats:
    """(N,) as ``looks.likeness`` is of keypoints.

    What the density about a place, times this, is to the usual clutter of the datum's word.

    In a pattern nothing is rarer than that: a side is found elsewhere with the chance ``pattern``.
    """
    usual = clutter_density(kb, data, found.datum)
    like = found.rare * usual * sigma * np.sqrt(2.0 * np.pi)
    if found.pattern > 0.0:
        like = np.minimum(like, usual / np.maximum(found.pattern * density(found.off, sigma), 1e-300))
    return np.asarray(like)
