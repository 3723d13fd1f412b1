"""What each view cell of each type shows: its sights, with their types, places and angles.

A *sight* is one appearance of one feature: a lobe. From a cell it is seen if its lobe holds the viewpoint and the
feature is not Behind its host.

* ``Sights``: of T types, C cells each, at most V sights a cell, as arrays over all types
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kb.clouds.lobes import in_lobe
from plogic.match.gamma.screen_angles import screen_angle
from plogic.match.hand.view_cells import DISTANCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from plogic.match.hand.type_index import TypeIndex

    Floats = NDArray[np.float64]

NOTHING = -1


@dataclass(frozen=True, eq=False)
class Sights:
    """Of T types and C cells, V sights at most, padded.

    Attributes:
        feature: (T, C, V) whose sight it is, −1 where there is none.
        looks: (T, C, V) number of its appearance type, −1 where there is none.
        xy: (T, C, V, 2) metres in the plane through the centre, x right and y down, from the centre.
        angle: (T, C, V) radians clockwise on the screen: what a detector's angle is, the x axis of the feature's frame.
        diameter: (T,) metres.
    """

    feature: NDArray[np.int32]
    looks: NDArray[np.int32]
    xy: NDArray[np.float32]
    angle: NDArray[np.float32]
    diameter: Floats


def sights_of(indices: Sequence[TypeIndex], number_of: Mapping[str, int]) -> Sights:
    """The sights of some types; ``number_of``: a number for each appearance type."""
    rows = [_of_type(index, number_of) for index in indices]
    most = max((row[0].shape[1] for row in rows), default=0)

    def stacked(column: int, empty: float) -> NDArray[np.float64]:
        arrays = [row[column] for row in rows]
        return np.stack(
            [
                np.pad(a, [(0, 0), (0, most - a.shape[1]), *[(0, 0)] * (a.ndim - 2)], constant_values=empty)
                for a in arrays
            ]
        )

    return Sights(
        stacked(0, NOTHING).astype(np.int32), stacked(1, NOTHING).astype(np.int32), stacked(2, 0.0).astype(np.float32),
        stacked(3, 0.0).astype(np.float32), np.array([index.cells.diameter for index in indices]),
    )  # fmt: skip


def _of_type(index: TypeIndex, number_of: Mapping[str, int]) -> tuple[NDArray[np.float64], ...]:
    """Features, looks, places and angles (C, V, ...) of one type's cells, padded on the right."""
    cells, table = index.cells, index.object_type.lobes
    viewpoints = cells.centre + DISTANCE * cells.diameter * cells.directions
    shown = in_lobe(table, viewpoints) & cells.visible[:, table.feature]
    count = shown.sum(axis=1)
    cell, lobe = np.nonzero(shown)
    slot = np.arange(len(cell)) - np.repeat(np.cumsum(count) - count, count)
    feature = table.feature[lobe]
    looks = np.array([number_of[name] for name in table.types], np.int64)[lobe]
    local = np.einsum("nij,nj->ni", cells.cell_from_object[cell], index.points[feature] - viewpoints[cell])
    angle = screen_angle(np.einsum("nij,nj->ni", cells.cell_from_object[cell], index.turns[feature]), local)
    shape = len(count), int(count.max(initial=0))
    features, kinds, angles = np.full(shape, float(NOTHING)), np.full(shape, float(NOTHING)), np.zeros(shape)
    places = np.zeros((*shape, 2))
    features[cell, slot], kinds[cell, slot], angles[cell, slot] = feature, looks, angle
    places[cell, slot] = cells.xy[cell, feature]
    return features, kinds, places, angles
