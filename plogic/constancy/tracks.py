"""Which data, one a view at most, may be of one place: pairs, extended view by view to what lies where they lead.

Vocabulary: ``Tracks``, T candidates with their appearance types and places.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.constancy.pairs import pairs_of
from plogic.constancy.places import Places, places_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.constancy.sights import Sights

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]
    Flags = NDArray[np.bool_]

MIN_PARALLAX = float(np.radians(2.0))
"""Between two lines of sight to a place: with less, views cannot tell how far away it is, and so not that it is one place."""
DEPTHS = 0.2, 10.0
"""m from a camera, least and most, between which unknown places are sought."""
GATE = 13.82
"""χ² of two degrees of freedom that one true datum in a thousand exceeds."""
RARE = 0.001
"""Share of true tracks whose residuals may be so large that they are lost."""


class Tracks(NamedTuple):
    """``data`` (T, V): in each view the index of a datum, -1 for none; ``kind`` (T,) the number of its type; where they lie."""

    data: Ints
    kind: Ints
    places: Places

    def some(self, which: Flags | Ints) -> Tracks:
        """Those of an index or a mask."""
        return Tracks(self.data[which], self.kind[which], self.places.some(which))


def tracks_of(sights: Sights) -> Tracks:
    """Pairs that meet, and what each becomes by taking up, view after view, the datum nearest to where its place is seen; each once."""
    current = _plausible(sights, pairs_of(sights))
    found = [current.data]
    for v in range(len(sights.views)):
        grown = _taken_up(sights, current, v)
        more = _plausible(sights, grown[~(grown == current.data).all(axis=1)])
        found.append(more.data)
        rest = current.some((grown == current.data).all(axis=1))
        current = _plausible(sights, np.unique(np.concatenate([rest.data, more.data]), axis=0))
    return _plausible(sights, np.unique(np.concatenate(found), axis=0))


def _plausible(sights: Sights, data: Ints) -> Tracks:
    """Those in front of their cameras, at a depth that is sought, with parallax enough, whose residuals are no larger than noise makes them."""
    from scipy.special import chdtri

    kind = _kinds(sights, data)
    places = places_of(sights, data, kind)
    freedom = 2 * (data >= 0).sum(axis=1) - 3
    depth = np.where(data >= 0, places.depth, np.nan)
    with np.errstate(invalid="ignore"):
        near = (~(depth < DEPTHS[0]) & ~(depth > DEPTHS[1])).all(axis=1)
    fits = places.chi2 < chdtri(np.maximum(freedom, 1), RARE)
    return Tracks(data, kind, places).some(places.good & near & fits & (places.parallax >= MIN_PARALLAX))


def _kinds(sights: Sights, data: Ints) -> Ints:
    """(T,) the appearance type of each track's data."""
    first = (data >= 0).argmax(axis=1)
    return np.asarray(sights.kind[first, data[np.arange(len(data)), first]]) if len(data) else np.zeros(0, np.intp)


def _taken_up(sights: Sights, tracks: Tracks, v: int) -> Ints:
    """(T, V) the tracks with the datum of view ``v`` that is nearest to where they lead; as they were where there is none, or one already."""
    grown = tracks.data.copy()
    free = np.flatnonzero(tracks.data[:, v] < 0)
    if not len(free) or not sights.xy.shape[1]:
        return grown
    squared = _squared(sights, tracks.some(free), v)
    squared[sights.kind[v][None] != tracks.kind[free][:, None]] = np.inf
    nearest = squared.argmin(axis=1)
    close = squared[np.arange(len(free)), nearest] < GATE
    grown[free[close], v] = nearest[close]
    return grown


def _squared(sights: Sights, tracks: Tracks, v: int) -> Floats:
    """(T, N) squared Mahalanobis distances of a view's data from where the tracks' places are seen, by the places' own uncertainty too."""
    R, t = sights.camera_from_world[v, :3, :3], sights.camera_from_world[v, :3, 3]
    points = tracks.places.at @ R.T + t
    z = points[:, 2:]
    safe = np.where(z > DEPTHS[0] / 10, z, np.nan)
    ideal = points[:, :2] / safe
    jacobian = (R[None, :2] - ideal[..., None] * R[None, 2:]) / safe[..., None]
    spread = jacobian @ tracks.places.covariance @ np.swapaxes(jacobian, 1, 2)
    spread = spread + np.eye(2) * sights.sigma[v, tracks.kind][:, None, None] ** 2
    (a, b), d = (spread[:, 0, 0], spread[:, 0, 1]), spread[:, 1, 1]
    off = sights.xy[v][None] - ideal[:, None]
    squared = (d[:, None] * off[..., 0] ** 2 - 2 * b[:, None] * off[..., 0] * off[..., 1] + a[:, None] * off[..., 1] ** 2) / (a * d - b * b)[:, None]
    return np.where(np.isnan(squared), np.inf, squared)
