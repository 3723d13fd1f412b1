"""Appearances that are sides of edges, where a pose puts them, and the sides around there that look right.

* ``SidePairs``: N pairs of such a place and a datum, with how far off each is
* ``facing``: which sides face alike and are of like colours, wherever they are
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.screen_angles import wrapped
from plogic.match.gamma.side_looks import colours_off

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_index import LearnedIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

AROUND = 32.0
"""Pixels around a place within which what looks as right is counted."""
TURNED = 0.34
"""Radians by which what looks right may face another way: less than a part of the grid's circle."""
FEW = 0.5
"""What is counted besides, since nowhere there can be none."""


@dataclass(frozen=True)
class SidePairs:
    """``place``, ``datum`` (N,) and how far off each datum is.

    ``turned`` (N,) radians by which it faces another way; ``off``, ``along`` (N,) pixels across the line and along it;
    ``colours`` (N,) a share, below 1 (``side_looks``).
    """

    place: Indices
    datum: Indices
    turned: Floats
    off: Floats
    along: Floats
    colours: NDArray[np.float32]

    def only(self, which: NDArray[np.bool_]) -> SidePairs:
        """Those of a mask (N,)."""
        return SidePairs(*(getattr(self, name.name)[which] for name in fields(self)))

    def usual(self, reach: Floats | float, count: int) -> Floats:
        """(count,) sides per pixel² that look right around each place, those aside that are within its ``reach`` (count,) pixels of its line."""
        within = np.broadcast_to(np.asarray(reach, float), count)
        clutter = np.abs(self.off) > within[self.place]
        area = np.pi * AROUND**2 - 4.0 * AROUND * np.minimum(within, AROUND / 2.0)
        return np.asarray((np.bincount(self.place[clutter], minlength=count) + FEW) / area)


def side_pairs(index: LearnedIndex, data: Data, lobes: Indices, uv: Floats, angle: Floats) -> SidePairs:
    """Of appearances ``lobes`` (Q,) that a pose puts at uv (Q, 2) pixels, facing angle (Q,) radians."""
    place, datum = data.sides.near(uv, AROUND, angle)
    right, down = (data.uv[:, axis][datum] - uv[:, axis][place] for axis in (0, 1))
    near = right * right + down * down < AROUND**2
    place, datum, right, down = place[near], datum[near], right[near], down[near]
    alike, turned, colours = facing(index.looks[lobes], angle, data, place, datum)
    place, datum, right, down = place[alike], datum[alike], right[alike], down[alike]
    cos, sin = np.cos(angle)[place], np.sin(angle)[place]
    return SidePairs(place, datum, turned, right * cos + down * sin, down * cos - right * sin, colours)


def facing(
    looks: NDArray[np.float32], angle: Floats, data: Data, side: Indices, datum: Indices
) -> tuple[Indices, Floats, NDArray[np.float32]]:
    """Of N pairs of sides, of looks (Q, 6) and facing angle (Q,) radians, and data, the M that face alike and are of like colours.

    Returns which (M,) they are, by how much they face another way, and how far off their colours are.
    """
    turned = wrapped(data.angle[datum] - angle[side])
    alike = np.flatnonzero(np.abs(turned) < TURNED)
    colours = colours_off(looks[side[alike]], data.looks[datum[alike]], coloured=data.coloured)
    right = colours < 1.0
    alike = alike[right]
    return alike, turned[alike], colours[right]
