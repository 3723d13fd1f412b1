"""Pairs without arms: two features and two appearances in one view cell fix roll and scale by themselves.

The way of a Γ whose detector reports places only. It costs cells × features² × appearances², so that it is taken cell by cell; and as no arm
refuses a pair, the other anchors' votes choose those that are kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.search.angles import wrapped
from plogic.search.pairs import MOST_PAIRS, Pairs
from plogic.search.votes import distance_maps, votes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.view_cells import ViewCells
    from plogic.search.votes import DistanceMaps

MOST_OF_CELL = 4_000
"""Pairs of one cell that are voted on; more are thinned evenly."""
LARGEST_JOIN = 100_000
"""Entries of one cell's join; of a larger one, pairs of features are left out evenly."""


def open_pairs(
    cells: ViewCells,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> Pairs:
    """Pairs of anchors and data that a cell allows within the range of ``scales``: at most ``MOST_PAIRS``, the best by the anchors' votes."""
    if not len(data.ids) or not allowed[anchors].any():
        none = np.zeros(0, dtype=np.intp)
        return Pairs(none, none, none, none, none, np.zeros(0), np.zeros(0))
    maps = distance_maps(allowed, data)
    found = [_of_cell(cells, c, anchors, allowed, data, scales) for c in range(len(cells.directions))]
    worth = np.concatenate([_votes(pairs, cells, anchors, maps, data) for pairs in found])
    every = Pairs(*(np.concatenate([getattr(pairs, name) for pairs in found]) for name in Pairs.__dataclass_fields__))
    if len(worth) <= MOST_PAIRS:
        return every
    return every.take(np.sort(np.argsort(-worth, kind="stable")[:MOST_PAIRS]))


def _votes(pairs: Pairs, cells: ViewCells, anchors: NDArray[np.intp], maps: DistanceMaps, data: Data) -> NDArray[np.float64]:
    """(N,) the share of the visible anchors that find a datum, each by how near it is."""
    return votes(pairs, cells, maps, np.ones(cells.visible.shape[1]), data, anchors)


def _of_cell(
    cells: ViewCells,
    c: int,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> Pairs:
    """The pairs of one cell, thinned evenly to ``MOST_OF_CELL``."""
    seen = anchors[cells.visible[c, anchors]]
    first, second = (seen[i] for i in np.triu_indices(len(seen), 1)[:2])
    stride = max(1, int(np.ceil(len(first) * len(data.ids) ** 2 / LARGEST_JOIN)))
    first, second = first[::stride], second[::stride]
    model = cells.xy[c, second] - cells.xy[c, first]
    image = data.ideal[None] - data.ideal[:, None]
    length = np.maximum(np.hypot(model[:, 0], model[:, 1]), 1e-9)
    scale = np.hypot(image[..., 0], image[..., 1])[None] / length[:, None, None]
    good = allowed[first][:, :, None] & allowed[second][:, None, :] & (scale > scales[0]) & (scale < scales[1])
    flat = np.flatnonzero(good)
    if len(flat) > MOST_OF_CELL:
        flat = flat[np.linspace(0, len(flat) - 1, MOST_OF_CELL).astype(np.intp)]
    p, a, b = np.unravel_index(flat, good.shape)
    angle = np.arctan2(image[a, b, 1], image[a, b, 0]) - np.arctan2(model[p, 1], model[p, 0])
    return Pairs(np.full(len(p), c), first[p], a, second[p], b, wrapped(angle), scale[p, a, b])
