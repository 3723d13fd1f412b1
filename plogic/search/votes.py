"""Votes: how many distinctive features of a coarse pose find an appearance of a right type near their place.

Typed distance maps answer that for all pairs at once: one map for each set of appearance types that some feature has.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.pairs import Pairs
    from plogic.search.view_cells import ViewCells

LOOSE = 0.10
"""Tolerance of a vote, in projected diameters: what a cell's width and the missing perspective may move a feature."""


@dataclass(frozen=True)
class DistanceMaps:
    """For each map, the distance in pixels to the nearest datum (H, W) and that datum's index (H, W); ``of_feature`` (F,) picks the map."""

    distance: NDArray[np.float32]
    nearest: NDArray[np.int32]
    of_feature: NDArray[np.intp]

    def look_up(self, places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Distance (..., F) and nearest datum (..., F) of ``places`` (..., F, 2) in ideal pixels; outside the image, infinity and −1."""
        height, width = self.distance.shape[1:]
        u, v = np.rint(places[..., 0]), np.rint(places[..., 1])
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        column, row = np.where(inside, u, 0).astype(np.intp), np.where(inside, v, 0).astype(np.intp)
        which = np.broadcast_to(self.of_feature, u.shape)
        distance = np.where(inside, self.distance[which, row, column], np.inf)
        return distance, np.where(inside, self.nearest[which, row, column], -1)


def distance_maps(allowed: NDArray[np.bool_], data: Data) -> DistanceMaps:
    """One map for each distinct row of ``allowed`` (F, A). A row without a datum gives a map of infinities."""
    rows, of_feature = np.unique(allowed, axis=0, return_inverse=True)
    shape = (data.camera.height, data.camera.width)
    made = [_one_map(np.flatnonzero(row), data.ideal, shape) for row in rows]
    return DistanceMaps(np.stack([m[0] for m in made]), np.stack([m[1] for m in made]), of_feature.reshape(-1))


def _one_map(
    members: NDArray[np.intp], places: NDArray[np.float64], shape: tuple[int, int]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    pixels = np.rint(places[members]).astype(int)
    inside = (pixels >= 0).all(axis=1) & (pixels[:, 0] < shape[1]) & (pixels[:, 1] < shape[0])
    members, pixels = members[inside], pixels[inside]
    if not len(members):
        return np.full(shape, np.inf, dtype=np.float32), np.full(shape, -1, dtype=np.int32)
    free = np.full(shape, 255, dtype=np.uint8)
    free[pixels[:, 1], pixels[:, 0]] = 0
    distance, label = cv2.distanceTransformWithLabels(free, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    owner = np.full(int(label.max()) + 1, -1, dtype=np.int32)
    owner[label[pixels[:, 1], pixels[:, 0]]] = members
    return np.asarray(distance), owner[label]


def places_of(pairs: Pairs, cells: ViewCells, data: Data) -> NDArray[np.float64]:
    """(N, F, 2) ideal pixels where each coarse pose puts each feature: the cell's picture turned, scaled and laid on the first datum."""
    model = cells.xy[pairs.cell] - cells.xy[pairs.cell, pairs.feature][:, None]
    cos, sin = np.cos(pairs.roll)[:, None], np.sin(pairs.roll)[:, None]
    turned = np.stack([cos * model[..., 0] - sin * model[..., 1], sin * model[..., 0] + cos * model[..., 1]], axis=-1)
    return np.asarray(data.ideal[pairs.datum][:, None] + pairs.scale[:, None, None] * turned)


def votes(
    pairs: Pairs, cells: ViewCells, maps: DistanceMaps, weights: NDArray[np.float64], data: Data
) -> NDArray[np.float64]:
    """(N,) Σ weight of the visible features, each by how near its nearest datum is; in units of the visible features' whole weight."""
    visible = cells.visible[pairs.cell] * weights
    distance, _ = maps.look_up(places_of(pairs, cells, data))
    tolerance = LOOSE * cells.diameter * pairs.scale[:, None]
    near = np.maximum(0.0, 1.0 - distance / tolerance)
    return np.asarray((visible * near).sum(axis=1) / np.maximum(visible.sum(axis=1), 1e-12))


def best_apart(
    votes_of: NDArray[np.float64], pairs: Pairs, cells: ViewCells, data: Data, most: int, also: Sequence[int] = ()
) -> NDArray[np.intp]:
    """Indices of at most ``most`` pairs, best first, no two alike (place within 8 % of the size, scale 15 %, direction and roll 12°)."""
    order = np.argsort(-votes_of, kind="stable")[: 30 * most]
    centre = places_of(pairs.take(order), cells, data).mean(axis=1)
    size = pairs.scale[order] * cells.diameter
    direction, roll = cells.directions[pairs.cell[order]], pairs.roll[order]
    alive, kept = np.ones(len(order), dtype=bool), list(also)
    for i in range(len(order)):
        if not alive[i]:
            continue
        kept.append(int(order[i]))
        if len(kept) >= most:
            break
        near = np.linalg.norm(centre - centre[i], axis=1) < 0.08 * size[i]
        near &= np.abs(np.log(size / size[i])) < 0.15
        near &= (direction @ direction[i] > np.cos(np.radians(12.0))) & (
            np.cos(roll - roll[i]) > np.cos(np.radians(12.0))
        )
        alive &= ~near
    return np.array(kept, dtype=np.intp)
