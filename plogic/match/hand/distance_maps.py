"""Typed distance maps: how far each place of the image is from a datum of a right type, for all poses at once.

One map for each set of appearance types that some feature has.

* ``Drawn(data).maps(allowed, some, covered)``: those of some data of one Γ; what was drawn once is kept
* ``distance_maps(allowed, data, covered)``: those of some data, once
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Data


@dataclass(frozen=True)
class DistanceMaps:
    """For each map, the distance in pixels to the nearest datum (H, W) and that datum's row in Γ (H, W).

    ``of_set`` (S,) picks the map of each set of looks; ``number``: the index of each row of Γ among some data, the last
    −1, of none.

    ``covered`` (H, W): where an accepted opaque object stands, so that a feature there may well be hidden.
    """

    distance: NDArray[np.float32]
    nearest: NDArray[np.int32]
    of_set: Indices
    number: Indices
    covered: Mask

    def look_up(self, places: NDArray[Any], sets: Indices) -> tuple[NDArray[Any], Indices]:
        """Distance (..., F) and nearest datum (..., F) of ``places`` (..., F, 2) in ideal pixels.

        ``sets`` (..., F): as what they look. Outside the image, infinity and −1.
        """
        pixel, inside = _pixel(places, self.covered.shape)
        index = pixel + self.of_set[sets] * self.covered.size  # all maps are one after the other
        row = np.where(inside, self.nearest.ravel()[index], -1)
        return np.where(inside, self.distance.ravel()[index], np.inf), self.number[row]

    def seen_at(self, places: NDArray[Any], sets: Indices) -> tuple[NDArray[Any], Mask]:
        """The distances alone, and whether an accepted object stands at the places."""
        pixel, inside = _pixel(places, self.covered.shape)
        index = pixel + self.of_set[sets] * self.covered.size
        distance = np.where(inside, self.distance.ravel()[index], np.float32(np.inf))
        return distance, np.asarray(inside & self.covered.ravel()[pixel]) if self.anything else np.zeros_like(inside)

    def is_covered(self, places: NDArray[Any]) -> Mask:
        """Whether an accepted object stands at each place (..., 2) of the image and may hide a feature there."""
        return covered_at(self.covered, places) if self.anything else np.zeros(places.shape[:-1], bool)

    @cached_property
    def anything(self) -> bool:
        """Whether any place is covered."""
        return bool(self.covered.any())


def covered_at(covered: Mask, places: NDArray[Any]) -> Mask:
    """Whether a mask (H, W) of the ideal image holds at places (..., 2)."""
    index, inside = _pixel(places, covered.shape)
    return np.asarray(inside & covered.ravel()[index])


def _pixel(places: NDArray[Any], shape: tuple[int, ...]) -> tuple[Indices, Mask]:
    """Flat index of the pixel of each place (0 outside), and whether it is inside an image of ``shape`` (H, W)."""
    height, width = shape
    column, row = np.rint(places[..., 0]), np.rint(places[..., 1])
    inside = (column >= 0) & (row >= 0) & (column < width) & (row < height)
    return np.where(inside, row * width + column, 0).astype(np.intp), inside


EMPTY = 0
"""The map of no datum: of infinities."""


SPARE = 2**25
"""Pixels of maps that are kept besides those that are asked for: 256 MB."""


@dataclass(eq=False)
class Drawn:
    """The maps of one Γ, each drawn once: of the data ``whole``, of which some are asked about again and again.

    ``distance``, ``nearest`` (N, H, W) one after the other; ``slot``: where that of some rows of Γ is.
    """

    whole: Data
    distance: NDArray[np.float32] = field(init=False)
    nearest: NDArray[np.int32] = field(init=False)
    slot: dict[bytes, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """No map is there yet."""
        self._room(0)

    def maps(
        self, allowed: Mask, data: Data, covered: Mask | None = None, check: Callable[[], None] = unhurried
    ) -> DistanceMaps:
        """One map for each distinct row of ``allowed`` (S, A), the data that look as of one set.

        A row without a datum gives a map of infinities.

        ``check`` is called before each, and may raise to end it.
        """
        rows, of_set = np.unique(allowed, axis=0, return_inverse=True)
        members = [data.rows[row] for row in rows]
        keys = [some.tobytes() for some in members]
        if len(self.distance) < len(self.slot.keys() | set(keys)):
            self._room(len(keys) + min(len(keys), SPARE // self.distance[EMPTY].size))
        for key, some in zip(keys, members, strict=True):
            if key not in self.slot:
                check()
                self.slot[key] = len(self.slot)
                _draw_map(some, self.whole.ideal, self.distance[self.slot[key]], self.nearest[self.slot[key]])
        number = np.full(len(self.whole.ids) + 1, -1)
        number[data.rows] = np.arange(len(data.rows))
        nothing = np.zeros(self.distance.shape[1:], dtype=bool) if covered is None else covered
        slots = np.array([self.slot[key] for key in keys], np.intp)
        return DistanceMaps(self.distance, self.nearest, slots[of_set.reshape(-1)], number, nothing)

    def _room(self, maps: int) -> None:
        """Forget all, and have room for so many maps, which take memory when they are drawn."""
        shape = (maps + 1, self.whole.camera.height, self.whole.camera.width)
        self.distance, self.nearest = np.empty(shape, np.float32), np.empty(shape, np.int32)
        self.slot.clear()
        self.slot[b""] = EMPTY
        self.distance[EMPTY], self.nearest[EMPTY] = np.inf, -1


def distance_maps(
    allowed: Mask, data: Data, covered: Mask | None = None, check: Callable[[], None] = unhurried
) -> DistanceMaps:
    """The maps of some data (``Drawn.maps``)."""
    return Drawn(data.whole).maps(allowed, data, covered, check)


def _draw_map(members: Indices, places: Floats, distance: NDArray[np.float32], nearest: NDArray[np.int32]) -> None:
    """Write one map (H, W) over ``distance`` and ``nearest``: of infinities and −1 where no datum is inside."""
    import cv2  # kb check judges types without a picture

    distance[:], nearest[:] = np.inf, -1
    pixels = np.rint(places[members])
    # of what the lens images nowhere, False
    inside = (pixels >= 0).all(axis=1) & (pixels < distance.shape[::-1]).all(axis=1)
    members, pixels = members[inside], pixels[inside].astype(int)
    if not len(members):
        return
    free = np.full(distance.shape, 255, dtype=np.uint8)
    free[pixels[:, 1], pixels[:, 0]] = 0
    _, label = cv2.distanceTransformWithLabels(free, cv2.DIST_L2, 5, distance, nearest, cv2.DIST_LABEL_PIXEL)
    owner = np.full(int(label.max()) + 1, -1, dtype=np.int32)
    owner[label[pixels[:, 1], pixels[:, 0]]] = members
    nearest[:] = owner[label]
