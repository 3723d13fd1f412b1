"""Two data of one type in two views that may be one place: epipolar consistency, by Sampson's distance."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.sequence.constancy.sight_lines import Sights

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

GATE = 10.83
"""χ² of one degree of freedom that one true pair in a thousand exceeds."""
LEAST_BASELINE = 1e-4
"""m between two cameras, below which nothing can be triangulated."""


def pairs_of(sights: Sights) -> Ints:
    """(T, V) tracks of two data each, of one type, whose lines of sight meet within the noise."""
    count = len(sights.views)
    found = [_between(sights, i, j) for i, j in combinations(range(count), 2)]
    return np.concatenate([np.zeros((0, count), np.intp), *found])


def _between(sights: Sights, i: int, j: int) -> Ints:
    """(T, V) those of two views."""
    if np.linalg.norm(sights.eye[i] - sights.eye[j]) < LEAST_BASELINE:
        return np.zeros((0, len(sights.views)), np.intp)
    same = (sights.kind[i][:, None] == sights.kind[j]) & (sights.kind[i] >= 0)[:, None]
    a, b = np.nonzero(same)
    close = sampson(sights, i, j, a, b) < GATE
    tracks = np.full((int(close.sum()), len(sights.views)), -1, np.intp)
    tracks[:, i], tracks[:, j] = a[close], b[close]
    return tracks


def sampson(sights: Sights, i: int, j: int, a: Ints, b: Ints) -> Floats:
    """(T,) squared distance from the epipolar lines, in variances, of the data ``a`` (T,) of view i and ``b`` (T,) of view j."""
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
