"""Links: pairs of junctions that an edge joins, in the cloud and in the image (§6.3).

A *link* of the cloud is a pair of features of which one's edge ends at the other; a link of Γ is a pair of junctions of
which one's arm points at the other. Laid onto each other in a view cell, the two fix roll and scale; the junctions'
other arms must then lie on the features' other edges. All arms are kept as bits of a 64-bit word, relative to the link,
so that millions of combinations are tested in milliseconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import unhurried
from plogic.match.gamma.row_blocks import blocks
from plogic.match.gamma.screen_angles import wrapped
from plogic.match.hand.coarse_pairs import ARM_TOLERANCE, MOST_PAIRS, Pairs

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.hand.view_cells import ViewCells

BINS = 64
"""Directions that an arm's angle is told apart to, 5.6° each."""
POINTING = np.radians(6.0)
"""How far a junction's arm may point past the other junction."""
ALONG_ONE_ARM = 3
"""Junctions that one arm is linked to, the nearest: an edge ends soon, but another object's outline may cross it
first."""
STRAIGHT = np.cos(np.radians(1.0))
"""An edge of the cloud ends at a feature that lies within 1° of its direction."""


@dataclass(frozen=True)
class DataLinks:
    """N links of Γ: ``first``, ``second`` (N,) data; ``angle`` (N,) of the line from first to second; ``length`` (N,) pixels."""

    first: NDArray[np.intp]
    second: NDArray[np.intp]
    angle: NDArray[np.float64]
    length: NDArray[np.float64]


def feature_links(points: NDArray[np.float64], arms: list[NDArray[np.float64]]) -> NDArray[np.intp]:
    """(N, 2) ordered pairs of features (F, 3) that an edge joins, both ways round; ``arms`` are each feature's edge directions."""
    found = set()
    for f, directions in enumerate(arms):
        for direction in directions:
            step = points - points[f]
            along, length = step @ direction, np.linalg.norm(step, axis=1)
            on = np.flatnonzero((length > 0) & (along >= STRAIGHT * length))
            ends = [g for g in on if len(arms[g])]
            if ends:
                g = min(ends, key=lambda g: length[g])
                found |= {(f, int(g)), (int(g), f)}
    return np.array(sorted(found), dtype=np.intp).reshape(-1, 2)


def data_links(data: Data, check: Callable[[], None] = unhurried) -> DataLinks:
    """Every arm to the nearest junctions that it points at; ``check`` is called between blocks of junctions, and may raise to end it."""
    armed = np.flatnonzero(np.isfinite(data.arms).any(axis=1))
    found = [_links_from(armed[some], data, check) for some in blocks(len(armed), len(data.ids))]
    if not found:
        found = [_links_from(armed, data, check)]
    return DataLinks(
        *(np.concatenate([getattr(links, name) for links in found]) for name in DataLinks.__dataclass_fields__)
    )


def _links_from(junctions: NDArray[np.intp], data: Data, check: Callable[[], None]) -> DataLinks:
    """The links of some junctions (J,), by the first, then by the second."""
    check()
    step = data.ideal[None] - data.ideal[junctions][:, None]
    length, angle = np.hypot(step[..., 0], step[..., 1]), np.arctan2(step[..., 1], step[..., 0])
    apart = (length > 1.0) & (length < np.inf)
    pairs = set()
    for k in range(data.arms.shape[1]):
        off = np.abs(wrapped(angle - data.arms[junctions, k : k + 1]))
        rows, columns = np.nonzero((off < POINTING) & apart)
        order = np.lexsort((length[rows, columns], rows))
        nth = np.arange(len(rows)) - np.searchsorted(rows, rows)
        near = order[nth < ALONG_ONE_ARM]
        pairs |= set(zip(rows[near].tolist(), columns[near].tolist(), strict=True))
    index = np.array(sorted(pairs), dtype=np.intp).reshape(-1, 2)
    row, second = index[:, 0], index[:, 1]
    return DataLinks(junctions[row], second, angle[row, second], length[row, second])


def linked_pairs(
    cells: ViewCells,
    links: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
    check: Callable[[], None] = unhurried,
) -> Pairs:
    """Every link of the cloud on every link of Γ, in every cell that shows both features; those whose arms fit best, at most ``MOST_PAIRS``.

    ``links`` (N, 2) as from ``feature_links``; ``allowed`` (F, A) the compatible types; ``scales`` the range of pixels
    a metre; ``check`` is called between blocks, and may raise to end it.
    """
    found = data_links(data, check)
    cell, link = np.nonzero(cells.visible[:, links[:, 0]] & cells.visible[:, links[:, 1]])
    f, g = links[link, 0], links[link, 1]
    step = cells.xy[cell, g] - cells.xy[cell, f]
    length, angle = np.hypot(step[:, 0], step[:, 1]), np.arctan2(step[:, 1], step[:, 0])
    ends = [
        (
            feature,
            datum,
            _words(cells.arms[cell, feature] - angle[:, None]),
            _bins(data.arms[datum] - found.angle[:, None]),
        )
        for feature, datum in ((f, found.first), (g, found.second))
    ]
    row, column, score = np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0, np.int8)
    for some in blocks(len(cell), len(found.first)):
        check()
        scale = _scales(found.length, length[some])
        legal = (scale > scales[0]) & (scale < scales[1])
        for feature, datum, _, _ in ends:
            legal &= allowed[feature[some]][:, datum]
        more, beside = np.nonzero(legal)
        more, fits = more + some.start, np.zeros(len(more), np.int8)
        for _, _, masks, bins in ends:
            hits, enough = _agreement(masks, bins, more, beside)
            more, beside, fits = more[enough], beside[enough], (fits + hits)[enough]
        row, column, score = (np.concatenate(both) for both in ((row, more), (column, beside), (score, fits)))
        if len(row) > MOST_PAIRS:
            best = np.sort(np.argsort(-score, kind="stable")[:MOST_PAIRS])
            row, column, score = row[best], column[best], score[best]
    roll, scale = wrapped(found.angle[column] - angle[row]), _scales(found.length[column], length[row], each=True)
    return Pairs(cell[row], f[row], found.first[column], g[row], found.second[column], roll, scale.astype(float))


def _scales(image: NDArray[np.float64], cloud: NDArray[np.float64], *, each: bool = False) -> NDArray[np.float32]:
    """Pixels a metre of lengths in the image (D,) by those of the cloud (M,): of all (M, D), or of ``each`` two (D,)."""
    cloud = np.maximum(cloud, 1e-9)
    return np.asarray((image / cloud if each else image[None] / cloud[:, None]).astype(np.float32))


def _agreement(
    masks: NDArray[np.uint64], bins: NDArray[np.int64], row: NDArray[np.intp], column: NDArray[np.intp]
) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
    """How many arms of datum ``column`` (N,) lie on edges of feature ``row`` (N,), (N,), and whether they are enough.

    All arms of an L must fit, all but one of three or four, three of five: detectors lose arms, and texture adds some.
    ``bins`` (D, K) are arms' bins, ``masks`` (M,) words of edges.
    """
    words, hits = masks[row], np.zeros(len(row), dtype=np.int8)
    for k in range(bins.shape[1]):
        shift = np.where(bins[:, k] >= 0, bins[:, k], 0).astype(np.uint64)
        there = (bins[:, k] >= 0).astype(np.uint64)
        hits += ((words >> shift[column]) & there[column]).astype(np.int8)
    number = (bins >= 0).sum(axis=1)
    needed = np.maximum(np.minimum(number, 2), np.ceil(0.6 * number)).astype(np.int8)
    return hits, hits >= needed[column]


def _bins(angles: NDArray[np.float64]) -> NDArray[np.int64]:
    """The bin of each angle, −1 for none."""
    index = np.floor(np.nan_to_num(angles, nan=0.0) / (2.0 * np.pi) * BINS + 0.5).astype(np.int64) % BINS
    return np.where(np.isnan(angles), -1, index)


def _words(angles: NDArray[np.float64]) -> NDArray[np.uint64]:
    """(M,) words with the bits set that lie within ``ARM_TOLERANCE`` of one of the angles (M, P)."""
    spread = int(ARM_TOLERANCE / (2.0 * np.pi) * BINS + 0.5)
    words = np.zeros(len(angles), dtype=np.uint64)
    middle = _bins(angles)
    for offset in range(-spread, spread + 1):
        bits = np.where(middle >= 0, np.uint64(1) << ((middle + offset) % BINS).astype(np.uint64), np.uint64(0))
        words |= np.bitwise_or.reduce(bits, axis=1) if bits.shape[1] else np.uint64(0)
    return words
