"""Features come in objects: where some are certain, others are near. The second look's prior over places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.sequence.constancy.tracks import Tracks

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

NEIGHBOURS = 3
"""The spacing of some places is the median distance to the neighbour of this number."""
SHARE = 0.5
"""Share of the features that are taken to be near certain ones; the others are anywhere."""
FEWEST = 4
"""Certain features below which nothing is said of where others are."""


def spacing(at: Floats) -> float:
    """m: the median distance of places (N, 3) to their third neighbours; to the farthest where there are fewer."""
    from scipy.spatial import cKDTree

    if len(at) < 2:
        return 0.0
    distances, _ = cKDTree(at).query(at, k=min(NEIGHBOURS, len(at) - 1) + 1)
    return float(np.median(distances[:, -1]))


@dataclass(frozen=True, eq=False)
class Company:
    """Certain tracks: their data (G, V), places (G, 3) m, and the spacing of these."""

    data: Ints
    at: Floats
    reach: float

    def log_place(self, tracks: Tracks, elsewhere: Floats) -> Floats:
        """The logarithms of p(X̂) (T,) with ``elsewhere`` (T,) being that of the first look: half of it, and half normal about each certain place.

        A track does not keep itself company: certain ones that share a datum with it say nothing of it.
        """
        spread = tracks.places.covariance + self.reach**2 * np.eye(3)
        off = tracks.places.at[:, None] - self.at
        squared = np.einsum("tgi,tij,tgj->tg", off, np.linalg.inv(spread), off)
        near = np.exp(-0.5 * squared) / np.sqrt((2.0 * np.pi) ** 3 * np.linalg.det(spread))[:, None]
        own = ((tracks.data[:, None] == self.data) & (self.data >= 0)).any(axis=-1)
        density = np.where(own, 0.0, near).sum(axis=1) / len(self.at)
        return np.asarray(np.log((1.0 - SHARE) * np.exp(elsewhere) + SHARE * density))


def company_of(data: Ints, at: Floats) -> Company | None:
    """Of certain tracks (G, V) at places (G, 3); None of too few."""
    reach = spacing(at)
    return Company(data, at, reach) if len(at) >= FEWEST and reach > 0.0 else None
