"""Appearances that are sides of edges, where a pose puts them, and the sides around there that look right.

* ``SidePairs``: N pairs of such a place and a datum, with how far off each is
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from plogic.search.learnt.side_looks import colours_off

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data
    from plogic.search.learnt.index import LearntIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

AROUND = 32.0
"""Pixels around a place within which what looks as right is counted."""
FEW = 0.5
"""What is counted besides, since nowhere there can be none."""


@dataclass(frozen=True)
class SidePairs:
    """``place``, ``datum`` (N,) and how far off each datum is.

    ``turned`` (N,) radians by which it faces another way; ``off``, ``along`` (N,) pixels across the line and along it; ``colours`` (N,) a share,
    below 1 (``side_looks``).
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
        clutter = (np.abs(self.off) > within[self.place]) & (self.off**2 + self.along**2 < AROUND**2)
        area = np.pi * AROUND**2 - 4.0 * AROUND * np.minimum(within, AROUND / 2.0)
        return np.asarray((np.bincount(self.place[clutter], minlength=count) + FEW) / area)


def side_pairs(index: LearntIndex, data: Data, lobes: Indices, uv: Floats, angle: Floats, facing: float) -> SidePairs:
    """Of appearances ``lobes`` (Q,) that a pose puts at uv (Q, 2) pixels, facing angle (Q,) radians; ``facing``: by how much another way at most."""
    place, datum = data.sides.near(uv, angle)
    turned = (data.angle[datum] - angle[place] + np.pi) % (2.0 * np.pi) - np.pi
    alike = np.abs(turned) < facing
    place, datum, turned = place[alike], datum[alike], turned[alike]
    colours = colours_off(index.looks[lobes[place]], data.looks[datum], coloured=data.coloured)
    right = colours < 1.0
    place, datum, turned, colours = place[right], datum[right], turned[right], colours[right]
    apart, cos, sin = data.uv[datum] - uv[place], np.cos(angle)[place], np.sin(angle)[place]
    return SidePairs(place, datum, turned, apart[:, 0] * cos + apart[:, 1] * sin, apart[:, 1] * cos - apart[:, 0] * sin, colours)
