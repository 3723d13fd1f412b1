"""Whether the image goes on like this: a checkered floor shows the sides of a square's edges at every second tile.

What stands out is evidence; what would be found as well were the whole hypothesis moved to other places nearby is the
pattern of the image, not an object in it. Sides are counted one by one, as if clutter were without order, so a pattern
must be looked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.learned.side_pairs import facing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

SOME = 20
"""Sides that are looked for elsewhere, evenly chosen."""
AWAY = (0.5, 2.0)
"""How far elsewhere is, in diagonals of the sides' own rectangle."""
CELL = 5.0
"""Pixels: a side is found elsewhere that is within a square of two such cells."""
OTHERS = 3
"""So many other places must show it: one or two more objects of one type may stand beside it."""


def share_elsewhere(uv: Floats, angle: Floats, looks: NDArray[np.float32], data: Data) -> float:
    """The share of sides at uv (N, 2) pixels, facing angle (N,), of looks (N, 6), that is found at each of ``OTHERS`` other places, apart."""
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
    """Of all pairs of a side and a datum that looks like it, wherever it is: the side's number, and how far it is to the datum, pixels."""
    side, datum = data.sides.facing(angle)
    alike = facing(looks, angle, data, side, datum)[0]
    return side[alike], data.uv[datum[alike]] - uv[side[alike]]
