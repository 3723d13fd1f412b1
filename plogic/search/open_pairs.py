"""Pairs without arms: two features and two appearances in one view cell fix roll and scale by themselves.

The way of a Γ whose detector reports places only. It costs cells × features² × appearances², so that it is taken cell by cell.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.search.pairs import thinned, turn

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.pairs import Pairs
    from plogic.search.view_cells import ViewCells

LARGEST_JOIN = 2_000_000
"""Entries of one cell's join; a larger one is thinned evenly."""


def open_pairs(
    cells: ViewCells,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> Pairs:
    """All pairs of anchors and data that a cell allows within the range of ``scales``, thinned evenly to ``MOST_PAIRS``."""
    blocks = [_of_cell(cells, c, anchors, allowed, data, scales) for c in range(len(cells.directions))]
    columns = [np.concatenate(column) for column in zip(*blocks, strict=True)]
    return thinned(columns)


def _of_cell(
    cells: ViewCells,
    c: int,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> tuple[NDArray[Any], ...]:
    seen = anchors[cells.visible[c, anchors]]
    first, second = (seen[i] for i in np.triu_indices(len(seen), 1)[:2])
    if not len(first) or not len(data.ids):
        return tuple(np.zeros(0) for _ in range(7))
    stride = max(1, int(np.ceil(len(first) * len(data.ids) ** 2 / LARGEST_JOIN)))
    first, second = first[::stride], second[::stride]
    model = cells.xy[c, second] - cells.xy[c, first]
    image = data.ideal[None] - data.ideal[:, None]
    length = np.maximum(np.hypot(model[:, 0], model[:, 1]), 1e-9)
    scale = np.hypot(image[..., 0], image[..., 1])[None] / length[:, None, None]
    good = allowed[first][:, :, None] & allowed[second][:, None, :] & (scale > scales[0]) & (scale < scales[1])
    p, a, b = np.nonzero(good)
    angle = np.arctan2(image[a, b, 1], image[a, b, 0]) - np.arctan2(model[p, 1], model[p, 0])
    return np.full(len(p), c), first[p], a, second[p], b, turn(angle), scale[p, a, b]
