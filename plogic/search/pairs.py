"""Seeds and pairs: the smallest sets of appearances that, inside one view cell, fix a whole pose (§6.3).

A *seed* is one feature matched to one appearance in one cell, with the roll that lays the junction's arms onto the feature's edges; a
detector that reports no arms leaves the roll open. A *pair* adds a second feature along the direction that cell and roll predict; its
distance gives the scale. Everything is done on arrays of thousands at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.view_cells import ViewCells

ARM_TOLERANCE = np.radians(16.0)
"""How far an arm may lie from the edge that the nearest cell predicts: half a cell's width plus the detector's error."""
PAIR_TOLERANCE = np.radians(12.0)
"""How far the line between two appearances may lie from the predicted one."""
MOST_PAIRS = 60_000
"""Pairs that are kept of one type; past it every n-th is taken (said in the trace)."""


@dataclass(frozen=True)
class Pairs:
    """N coarse poses: cell, first and second feature and appearance, (N,) each; ``roll`` radians; ``scale`` pixels per metre."""

    cell: NDArray[np.intp]
    feature: NDArray[np.intp]
    datum: NDArray[np.intp]
    other_feature: NDArray[np.intp]
    other_datum: NDArray[np.intp]
    roll: NDArray[np.float64]
    scale: NDArray[np.float64]

    def take(self, index: NDArray[np.intp]) -> Pairs:
        """The pairs at ``index``."""
        return Pairs(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


def turn(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bring angles into [−π, π]."""
    return np.asarray(angle - (2.0 * np.pi) * np.rint(angle / (2.0 * np.pi)))


def arms_agree(detected: NDArray[np.float64], predicted: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) whether each detected arm (N, K) lies near some predicted arm (N, P), each predicted one near a detected one where fully seen.

    NaN stands for "no such arm". A junction without arms agrees with anything; so does a feature without edges.
    """
    missing = np.isnan(detected)
    fine = np.zeros_like(missing)
    for k in range(predicted.shape[1]):
        fine |= np.abs(turn(detected - predicted[:, k : k + 1])) < ARM_TOLERANCE
    return np.asarray((fine | missing).all(axis=1) | np.isnan(predicted).all(axis=1))


def seeds(
    cells: ViewCells, anchors: NDArray[np.intp], allowed: NDArray[np.bool_], data: Data
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """All (cell, feature, datum, roll) in which the datum's arms fit the feature's edges; arrays of one length.

    ``anchors`` are the features to try, ``allowed`` (F, A) the compatible types.
    """
    cell, which = np.nonzero(cells.visible[:, anchors])
    feature = anchors[which]
    armed = np.asarray(np.isfinite(data.arms[:, :1]).any(axis=1))
    view, datum = np.nonzero(allowed[feature] & armed[None])
    cell, feature = cell[view], feature[view]
    predicted = cells.arms[cell, feature]
    found = []
    for k in range(predicted.shape[1]):
        roll = turn(data.arms[datum, 0] - predicted[:, k])
        good = ~np.isnan(roll)
        index = np.flatnonzero(good)
        index = index[arms_agree(data.arms[datum[index]], predicted[index] + roll[index, None])]
        found.append((cell[index], feature[index], datum[index], roll[index]))
    if not found:
        return _no_seeds()
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    return columns[0], columns[1], columns[2], columns[3]


def _no_seeds() -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    none = np.zeros(0, dtype=np.intp)
    return none, none, none, np.zeros(0)


def pairs(
    cells: ViewCells,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> Pairs:
    """Extend every seed by every anchor that its cell shows in the predicted direction, within the range of ``scales`` (pixels a metre)."""
    cell, feature, datum, roll = seeds(cells, anchors, allowed, data)
    blocks = [
        _partners(cells, block, anchors, allowed, data, scales)
        for block in _blocks((cell, feature, datum, roll), len(anchors) * max(1, len(data.ids)))
    ]
    joined = [np.concatenate(column) for column in zip(*blocks, strict=True)] if blocks else [np.zeros(0)] * 7
    return thinned(joined)


def thinned(columns: Sequence[NDArray[np.float64]]) -> Pairs:
    """Pairs from their seven columns; past ``MOST_PAIRS`` they are taken evenly."""
    cell, feature, datum, other_feature, other_datum = (column.astype(np.intp) for column in columns[:5])
    found = Pairs(cell, feature, datum, other_feature, other_datum, columns[5], columns[6])
    if len(cell) > MOST_PAIRS:
        return found.take(np.linspace(0, len(cell) - 1, MOST_PAIRS).astype(np.intp))
    return found


Seeds = tuple["NDArray[np.intp]", "NDArray[np.intp]", "NDArray[np.intp]", "NDArray[np.float64]"]


def _blocks(columns: Seeds, width: int, limit: int = 4_000_000) -> list[Seeds]:
    """Cut the seeds so that the arrays of the join stay below ``limit`` entries."""
    step = max(1, limit // max(1, width))
    return [
        (columns[0][i : i + step], columns[1][i : i + step], columns[2][i : i + step], columns[3][i : i + step])
        for i in range(0, len(columns[0]), step)
    ]


def _partners(
    cells: ViewCells,
    block: Seeds,
    anchors: NDArray[np.intp],
    allowed: NDArray[np.bool_],
    data: Data,
    scales: tuple[float, float],
) -> tuple[NDArray[np.float64], ...]:
    """Join one block of seeds with all anchors and data; columns as in ``Pairs``."""
    cell, feature, datum, roll = block
    model = (cells.xy[cell][:, anchors] - cells.xy[cell, feature][:, None]).astype(np.float32)
    image = data.ideal[None] - data.ideal[datum][:, None]
    predicted = np.arctan2(model[..., 1], model[..., 0]) + roll[:, None].astype(np.float32)
    lines = data.ideal[None] - data.ideal[:, None]
    seen = np.arctan2(lines[..., 1], lines[..., 0]).astype(np.float32)[datum]
    off = turn(seen[:, None, :] - predicted[:, :, None])
    shown = cells.visible[cell][:, anchors] & (anchors[None] != feature[:, None])
    s, g, b = np.nonzero((np.abs(off) < PAIR_TOLERANCE) & allowed[anchors][None] & shown[..., None])
    scale = np.hypot(image[s, b, 0], image[s, b, 1]) / np.maximum(np.hypot(model[s, g, 0], model[s, g, 1]), 1e-9)
    kept = (scale > scales[0]) & (scale < scales[1])
    s, g, b, scale = s[kept], g[kept], b[kept], scale[kept]
    new_roll = turn(roll[s] + off[s, g, b])
    other = anchors[g]
    fits = arms_agree(data.arms[b], cells.arms[cell[s], other] + new_roll[:, None])
    fits &= arms_agree(data.arms[datum[s]], cells.arms[cell[s], feature[s]] + new_roll[:, None])
    s, b, other = s[fits], b[fits], other[fits]
    return cell[s], feature[s], datum[s], other, b, new_roll[fits], scale[fits]
