"""Pairs without arms: two features and two appearances in one view cell fix roll and scale by themselves.

The way of a Γ whose detector reports places only. It costs cells × features² × appearances², so that it is taken cell
by cell; and as no arm refuses a pair, the other anchors' votes choose those that are kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.base.clock import unhurried
from plogic.match.gamma.row_blocks import blocks
from plogic.match.gamma.screen_angles import wrapped
from plogic.match.hand.coarse_pairs import MOST_PAIRS, Pairs
from plogic.match.hand.votes import distance_maps, votes

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.hand.view_cells import ViewCells
    from plogic.match.hand.votes import DistanceMaps

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
    check: Callable[[], None] = unhurried,
) -> Pairs:
    """Pairs of anchors and data that a cell allows within the range of ``scales``: at most ``MOST_PAIRS``, the best by the anchors' votes.

    ``check`` is called between cells, and blocks of their data, and may raise to end it.
    """
    if not len(data.ids) or not allowed[anchors].any():
        none = np.zeros(0, dtype=np.intp)
        return Pairs(none, none, none, none, none, np.zeros(0), np.zeros(0))
    maps = distance_maps(allowed, data)
    found = [_of_cell(cells, c, anchors, allowed, data, scales, check) for c in range(len(cells.directions))]
    worth = np.concatenate([_votes(pairs, cells, anchors, maps, data) for pairs in found])
    every = Pairs(*(np.concatenate([getattr(pairs, name) for pairs in found]) for name in Pairs.__dataclass_fields__))
    if len(worth) <= MOST_PAIRS:
        return every
    return every.take(np.sort(np.argsort(-worth, kind="stable")[:MOST_PAIRS]))


def _votes(
    pairs: Pairs, cells: ViewCells, anchors: NDArray[np.intp], maps: DistanceMaps, data: Data
) -> NDArray[np.float64]:
    """(N,) the share of the visible anchors that find a datum, each by how near it is."""
    return votes(pairs, cells, maps, np.ones(cells.visible.shape[1]), data, anchors)


def _of_cell(
    cells: ViewCells,
    c: int,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
    check: Callable[[], None],
) -> Pairs:
    """The pairs of one cell, thinned evenly to ``MOST_OF_CELL``.

    Where more than one pair of features is left, ``LARGEST_JOIN`` bounds the join; of one alone it is made in blocks,
    whose order is its own.
    """
    seen = anchors[cells.visible[c, anchors]]
    first, second = (seen[i] for i in np.triu_indices(len(seen), 1)[:2])
    stride = max(1, int(np.ceil(len(first) * len(data.ids) ** 2 / LARGEST_JOIN)))
    first, second = first[::stride], second[::stride]
    model = cells.xy[c, second] - cells.xy[c, first]
    length = np.maximum(np.hypot(model[:, 0], model[:, 1]), 1e-9)
    number, packed = len(data.ids), []
    for some in blocks(number, number) if len(first) == 1 else [slice(number)]:
        check()
        image = data.ideal[None] - data.ideal[some][:, None]
        scale = np.hypot(image[..., 0], image[..., 1])[None] / length[:, None, None]
        good = allowed[first][:, some, None] & allowed[second][:, None, :] & (scale > scales[0]) & (scale < scales[1])
        packed.append((int(np.count_nonzero(good)), good.size, np.packbits(good)))
    p, a, b = np.unravel_index(_thinned(packed), (len(first), number, number))
    step = data.ideal[b] - data.ideal[a]
    angle = np.arctan2(step[:, 1], step[:, 0]) - np.arctan2(model[p, 1], model[p, 0])
    return Pairs(
        np.full(len(p), c), first[p], a, second[p], b, wrapped(angle), np.hypot(step[:, 0], step[:, 1]) / length[p]
    )


def _thinned(packed: list[tuple[int, int, NDArray[np.uint8]]]) -> NDArray[np.intp]:
    """Where bits are set in blocks of them, one after the other: all, or ``MOST_OF_CELL`` evenly; a block: how many are set, and are there."""
    total = sum(count for count, _, _ in packed)
    wanted = np.arange(total) if total <= MOST_OF_CELL else np.linspace(0, total - 1, MOST_OF_CELL).astype(np.intp)
    found, before, start = [np.zeros(0, np.intp)], 0, 0
    for count, size, bits in packed:
        here = wanted[np.searchsorted(wanted, before) : np.searchsorted(wanted, before + count)]
        if len(here):
            found.append(start + np.flatnonzero(np.unpackbits(bits, count=size))[here - before])
        before, start = before + count, start + size
    return np.concatenate(found)
