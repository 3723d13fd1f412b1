"""Which sides of edges a pose's own are (D8), and how rare that is where they are.

Where along an edge a side is reported is arbitrary. So a side is that of an expected feature if it lies on its line,
near its place, faces as it does and has its colours; what is off along the line says nothing. Edges are everywhere:
what would look as right in the neighbourhood, were it in place, is counted, and a side is evidence for as much as it is
rarer than that.

* ``SideMatches``: N features and the sides that are theirs
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.screen_angles import screen_angle
from plogic.match.gamma.side_looks import looks_fit
from plogic.match.judged.evidence import clutter_density, density
from plogic.match.learned.patterns import share_elsewhere
from plogic.match.learned.side_pairs import TURNED, side_pairs

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_index import LearnedIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

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
    """``feature`` (N,), ``datum`` (N,); ``off`` (N,) pixels across the line; ``across`` (N, 2) unit vector there; ``rare`` (N,).

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
    index: LearnedIndex, posed: Hypothesis, data: Data, lobes: Indices, free: NDArray[np.bool_], reach: Floats
) -> SideMatches:
    """Of the appearances ``lobes``, which hold the viewpoint, those of sides in the image; of data that are ``free`` (A,).

    ``reach`` (F,) pixels across. One side a feature, one feature a side.
    """
    feature = index.cloud.feature[lobes]
    angle = screen_angle(index.cloud.up[lobes] @ posed.camera_from_object[:3, :3].T, posed.at[feature])
    inward = np.column_stack([np.cos(angle), np.sin(angle)])
    pairs, within = side_pairs(index, data, lobes, posed.uv[feature], angle), reach[feature]
    pairs = pairs.only(free[pairs.datum])
    usual = pairs.usual(within, len(lobes))
    mine = pairs.only((np.abs(pairs.off) <= within[pairs.place]) & (np.abs(pairs.along) <= ALONG))
    place, datum = mine.place, mine.datum
    rare = (
        _facing(mine.turned)
        * looks_fit(index.looks[lobes[place]], data.looks[datum], mine.colours, data.contrasts)
        / (2.0 * ALONG)
        / usual[place]
    )
    worth = np.log(rare) - 0.5 * (mine.off / NEARER) ** 2
    chosen = _one_to_one(feature[place], datum, worth)
    of = place[chosen]
    many = len(of) >= max(FEW_SIDES, MANY * len(np.unique(feature)))
    pattern = share_elsewhere(posed.uv[feature[of]], angle[of], index.looks[lobes[of]], data) if many else 0.0
    return SideMatches(
        feature[of], datum[chosen], mine.off[chosen], inward[of], rare[chosen], pattern if pattern >= ORDERED else 0.0
    )


def _facing(turned: Floats) -> Floats:
    """(N,) how much likelier a side is to face ``turned`` radians another way if it is right than evenly anywhere that may be right."""
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
    """(N,) as ``looks.likeness`` is of keypoints: what the density about a place, times this, is to the usual clutter of the datum's word.

    In a pattern nothing is rarer than that: a side is found elsewhere with the chance ``pattern``.
    """
    usual = clutter_density(kb, data, found.datum)
    like = found.rare * usual * sigma * np.sqrt(2.0 * np.pi)
    if found.pattern > 0.0:
        like = np.minimum(like, usual / np.maximum(found.pattern * density(found.off, sigma), 1e-300))
    return np.asarray(like)
