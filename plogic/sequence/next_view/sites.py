"""Sites: the places in a candidate's image where something may be reported, and with which probability in each world.

Features of several bodies that project within the match tolerance of one another, and of which a lobe reports one type,
are one site: a datum there would not tell them apart. What is reported at a site is independent of what is at others,
given the world.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from plogic.sequence.next_view.expected import Sightings
    from plogic.sequence.next_view.prospect import Prospect

    Floats = NDArray[np.float64]


class Sites(NamedTuple):
    """S sites: ``of`` (N,) the site of each sighting; ``expected`` (W, N) the sightings in each world; ``report`` (W, S) P(a datum there | w)."""

    of: NDArray[np.intp]
    expected: NDArray[np.bool_]
    report: Floats


def sites(seen: Sightings, prospect: Prospect, camera: Camera) -> Sites:
    """In world w a site reports with probability 1 − (1 − c) Π (1 − h) over the features that are Expected there in w.

    c: the probability of clutter of one of its types within the tolerance's area.
    """
    of, count = _merged(seen, prospect.tolerance)
    expected = seen.expected(prospect.present)
    miss = np.zeros((len(prospect.present), count))
    logs = np.log1p(-np.minimum(seen.hit, 1.0 - 1e-9))
    for n, site in enumerate(of):
        miss[:, site] += np.where(expected[:, n], logs[n], 0.0)
    return Sites(of, expected, -np.expm1(miss - _clutter(seen, of, count, prospect, camera)))


def _merged(seen: Sightings, tolerance: float) -> tuple[NDArray[np.intp], int]:
    """The site (N,) of each sighting, and their number: whatever lies near and shares a type, and what lies near that, in no order."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    number = len(seen.uv)
    if not number:
        return np.zeros(0, np.intp), 0
    pairs = cKDTree(seen.uv).query_pairs(tolerance, output_type="ndarray")
    alike = (
        pairs[(seen.looks[pairs[:, 0]] & seen.looks[pairs[:, 1]]).any(axis=1)] if len(pairs) else pairs.reshape(0, 2)
    )
    graph = coo_matrix((np.ones(len(alike)), (alike[:, 0], alike[:, 1])), shape=(number, number))
    count, of = connected_components(graph, directed=False)
    return np.asarray(of, np.intp), int(count)


def _clutter(seen: Sightings, of: NDArray[np.intp], count: int, prospect: Prospect, camera: Camera) -> Floats:
    """(S,) the expected number of data of clutter within the tolerance of a site, of the types that it may be reported as."""
    looks = np.zeros((count, len(seen.names)), bool)
    np.logical_or.at(looks, of, seen.looks)
    density = np.array([prospect.clutter.get(name, 1.0) for name in seen.names]) / float(camera.width * camera.height)
    return np.asarray(looks @ density * np.pi * prospect.tolerance**2)
