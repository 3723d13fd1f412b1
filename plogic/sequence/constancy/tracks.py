"""Which data, one a view at most, may be of one place: pairs, extended view by view to what lies where they lead.

Vocabulary: ``Tracks``, T candidates with their appearance types and places.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np

from geometry.arrays import Floats, Indices, Mask, pieces
from plogic.match.gamma.data import Columns
from plogic.sequence.constancy.sight_lines import Places, Sights, places_of

MIN_PARALLAX = float(np.radians(2.0))
"""Between two lines of sight to a place: with less, views cannot tell how far away it is, and so not that it is one
place."""
DEPTHS = 0.2, 10.0
"""m from a camera, least and most, between which unknown places are sought."""
GATE = 13.82
"""χ² of two degrees of freedom that one true datum in a thousand exceeds."""
STRONG, SMALL = 4, 3
"""Data of a track that is taken for the best of its kind; most of those that are kept besides what came of them."""
RARE = 0.001
"""Share of true tracks whose residuals may be so large that they are lost."""


@dataclass(frozen=True)
class Tracks(Columns):
    """``data`` (T, V): in each view the index of a datum, -1 for none; ``kind`` (T,) the number of its type.

    Where they lie.
    """

    data: Indices
    kind: Indices
    places: Places


def tracks_of(sights: Sights) -> Tracks:
    """Pairs that meet, each followed view after view by the datum nearest to its place's image; each once.

    Pairs of views that follow each other go first. Others that lie within what those became, of ``STRONG`` data or
    more, would become the same.
    """
    pairs = pairs_of(sights)
    next_to = ((pairs >= 0)[:, 1:] & (pairs >= 0)[:, :-1]).any(axis=1)
    first = _grown(sights, pairs[next_to])
    rest = pairs[~next_to]
    later = _grown(sights, rest[~_within(first[(first >= 0).sum(axis=1) >= STRONG], rest)])
    return _plausible(sights, _once(np.concatenate([first, later])))


def _grown(sights: Sights, pairs: Indices) -> Indices:
    """(T, V) pairs that are plausible, threes on the way, and what each came to in the end."""
    current = _plausible(sights, pairs)
    found = [current.data]
    for v in range(len(sights.views)):
        grown = _taken_up(sights, current, v)
        more = (grown != current.data).any(axis=1)
        longer = _plausible(sights, _once(grown[more]))
        found.append(longer.data[(longer.data >= 0).sum(axis=1) <= SMALL])
        current = Tracks.joined([longer, current.take(~more)])
    return np.concatenate([*found, current.data])


def _once(data: Indices) -> Indices:
    """Each of some tracks (T, V) once, in a fixed order."""
    short = np.ascontiguousarray(data, np.int32)
    rows = short.view(np.dtype((np.void, short.dtype.itemsize * short.shape[1]))).ravel()
    return np.asarray(data[np.sort(np.unique(rows, return_index=True)[1])])


def _within(tracks: Indices, pairs: Indices) -> Mask:
    """(T,) which pairs have both data in one of the tracks."""
    views, size = pairs.shape[1], int(max(tracks.max(initial=0), pairs.max(initial=0))) + 1
    codes = [
        ((i * size + tracks[both, i]) * views + j) * size + tracks[both, j]
        for i in range(views) for j in range(i + 1, views) if (both := (tracks[:, i] >= 0) & (tracks[:, j] >= 0)).any()
    ]  # fmt: skip
    i, j = np.nonzero(pairs >= 0)[1].reshape(-1, 2).T
    rows = np.arange(len(pairs))
    own = ((i * size + pairs[rows, i]) * views + j) * size + pairs[rows, j]
    return np.isin(own, np.concatenate([np.zeros(0, np.intp), *codes]))


def _plausible(sights: Sights, data: Indices) -> Tracks:
    """Those in front of their cameras, at a sought depth, with parallax enough and residuals as of noise."""
    from scipy.special import chdtri

    kind = _kinds(sights, data)
    places = places_of(sights, data, kind)
    freedom = 2 * (data >= 0).sum(axis=1) - 3
    depth = np.where(data >= 0, places.depth, np.nan)
    with np.errstate(invalid="ignore"):
        near = (~(depth < DEPTHS[0]) & ~(depth > DEPTHS[1])).all(axis=1)
    fits = places.chi2 < chdtri(np.maximum(freedom, 1), RARE)
    return Tracks(data, kind, places).take(places.good & near & fits & (places.parallax >= MIN_PARALLAX))


def _kinds(sights: Sights, data: Indices) -> Indices:
    """(T,) the appearance type of each track's data."""
    first = (data >= 0).argmax(axis=1)
    return np.asarray(sights.kind[first, data[np.arange(len(data)), first]]) if len(data) else np.zeros(0, np.intp)


def _taken_up(sights: Sights, tracks: Tracks, v: int) -> Indices:
    """(T, V) the tracks with the datum of view ``v`` that is nearest to where they lead.

    As they were where there is none, or one already.
    """
    grown = tracks.data.copy()
    free = np.flatnonzero(tracks.data[:, v] < 0 if sights.xy.shape[1] else [])
    for kind in np.unique(tracks.kind[free]):
        data = np.flatnonzero(sights.kind[v] == kind)
        for some in pieces(free[tracks.kind[free] == kind], 50, BLOCK) if len(data) else ():
            for these, nearest in _nearest(sights, tracks, some, v, data):
                grown[these, v] = nearest
    return grown


def _nearest(sights: Sights, tracks: Tracks, some: Indices, v: int, data: Indices) -> Iterator[tuple[Indices, Indices]]:
    """Those of ``some`` tracks of one type that lead near any of its ``data`` in a view, and the nearest datum of each.

    Squared Mahalanobis distances count, by places' uncertainty too; of equal ones the first.
    """
    from scipy.spatial import cKDTree

    ideal, spread = _images(sights, tracks.take(some), v)
    seen = np.isfinite(ideal).all(axis=1) & np.isfinite(spread).all(axis=(1, 2))
    some, ideal, spread = some[seen], ideal[seen], spread[seen]
    a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
    reach = np.sqrt(GATE * ((a + d) / 2.0 + np.hypot((a - d) / 2.0, b)))  # along the long axis
    tree = cKDTree(sights.xy[v, data])
    count = tree.query_ball_point(ideal, reach, return_length=True)
    bounds = np.searchsorted(np.cumsum(count), np.arange(BLOCK, count.sum() + BLOCK, BLOCK), side="left") + 1
    for rows in np.split(np.arange(len(some)), np.unique(bounds[:-1])):
        within = tree.query_ball_point(ideal[rows], reach[rows], return_sorted=True)
        row = np.repeat(rows, count[rows])
        near = data[np.fromiter(chain.from_iterable(within), np.intp, len(row))]
        off = sights.xy[v, near] - ideal[row]
        squared = d[row] * off[:, 0] ** 2 - 2 * b[row] * off[:, 0] * off[:, 1] + a[row] * off[:, 1] ** 2
        squared /= (a * d - b * b)[row]
        order = np.lexsort((near, squared, row))
        first = order[np.unique(row[order], return_index=True)[1]]
        first = first[squared[first] < GATE]
        yield some[row[first]], near[first]


def _images(sights: Sights, tracks: Tracks, v: int) -> tuple[Floats, Floats]:
    """Where tracks lead in a view: ideal places (T, 2), NaN behind it, and covariances (T, 2, 2) with a datum's."""
    R, t = sights.camera_from_world[v, :3, :3], sights.camera_from_world[v, :3, 3]
    points = tracks.places.at @ R.T + t
    safe = np.where(points[:, 2:] > DEPTHS[0] / 10, points[:, 2:], np.nan)
    ideal = points[:, :2] / safe
    jacobian = (R[None, :2] - ideal[..., None] * R[None, 2:]) / safe[..., None]
    spread = jacobian @ tracks.places.covariance @ np.swapaxes(jacobian, 1, 2)
    return ideal, spread + np.eye(2) * sights.sigma[v, tracks.kind][:, None, None] ** 2


PAIR_GATE = 10.83
"""χ² of one degree of freedom that one true pair in a thousand exceeds."""
LEAST_BASELINE = 1e-4
"""m between two cameras, below which nothing can be triangulated."""


def pairs_of(sights: Sights) -> Indices:
    """(T, V) tracks of two data each, of one type, whose lines of sight meet within the noise."""
    count = len(sights.views)
    found = [_between(sights, i, j) for i, j in combinations(range(count), 2)]
    return np.concatenate([np.zeros((0, count), np.intp), *found])


def _between(sights: Sights, i: int, j: int) -> Indices:
    """(T, V) those of two views."""
    if np.linalg.norm(sights.eye[i] - sights.eye[j]) < LEAST_BASELINE:
        return np.zeros((0, len(sights.views)), np.intp)
    found = [np.zeros((0, 2), np.intp)]
    for some in pieces(np.flatnonzero(sights.kind[i] >= 0), len(sights.kind[j]), BLOCK):
        a, b = np.nonzero(sights.kind[i, some][:, None] == sights.kind[j])
        close = sampson(sights, i, j, some[a], b) < PAIR_GATE
        found.append(np.column_stack([some[a[close]], b[close]]))
    pairs = np.concatenate(found)
    tracks = np.full((len(pairs), len(sights.views)), -1, np.intp)
    tracks[:, [i, j]] = pairs
    return tracks


BLOCK = 1_000_000
"""Pairs that are looked at together: a photo has thousands of data of its commonest word.

At most 400 bytes each (``tests/sequence/constancy/test_many_alike.py``).
"""


def sampson(sights: Sights, i: int, j: int, a: Indices, b: Indices) -> Floats:
    """(T,) squared distance from the epipolar lines, in variances, of data ``a`` (T,) of view i, ``b`` (T,) of j."""
    relative = sights.camera_from_world[j] @ np.linalg.inv(sights.camera_from_world[i])
    essential = _crossing(relative[:3, 3]) @ relative[:3, :3]
    one, two = (np.column_stack([sights.xy[v, which], np.ones(len(which))]) for v, which in ((i, a), (j, b)))
    lines_two, lines_one = one @ essential.T, two @ essential
    kind = sights.kind[i, a]
    variance = (lines_two[:, :2] ** 2).sum(axis=1) * sights.sigma[j, kind] ** 2 + (lines_one[:, :2] ** 2).sum(
        axis=1
    ) * sights.sigma[i, kind] ** 2
    return np.asarray((two * lines_two).sum(axis=1) ** 2 / np.maximum(variance, 1e-30))


def _crossing(t: Floats) -> Floats:
    """(3, 3) the matrix of t × ."""
    return np.array([[0.0, -t[2], t[1]], [t[2], 0.0, -t[0]], [-t[1], t[0], 0.0]])
