"""A peer of ``plogic bench constancy``.

Plain two-view epipolar matching, as one would write it who only has pairs of images.

Data of one type, each the other's nearest to its epipolar line, nearer than three standard deviations, with a place in
front of both cameras: physical. All the rest is noise. Of more views, each is matched with the next one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.constancy.score import Called
from plogic.sequence.constancy.sight_lines import places_of, sights_of
from plogic.sequence.constancy.tracks import sampson

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import Rates
    from plogic.sequence.constancy.sight_lines import Sights, View

NEAR = 9.0
"""Variances within which a datum is near an epipolar line."""


def epipolar(views: Sequence[View], unexplained: Mapping[str, Sequence[str]], rates: Rates) -> Called:
    """What the peer calls physical, pair by pair, and noise."""
    sights = sights_of(views, unexplained, rates)
    physical = [row for v in range(len(views) - 1) for row in _matched(sights, v, v + 1)]
    taken = {(view, datum) for row in physical for view, datum in row.items()}
    noise = {view.id: frozenset(d for d in sights.ids[v] if (view.id, d) not in taken) for v, view in enumerate(views)}
    return Called(tuple(physical), (), noise, {})


def _matched(sights: Sights, i: int, j: int) -> list[dict[str, str]]:
    a, b = np.nonzero((sights.kind[i][:, None] == sights.kind[j]) & (sights.kind[i] >= 0)[:, None])
    if not len(a):
        return []
    off = np.full((len(sights.kind[i]), len(sights.kind[j])), np.inf)
    off[a, b] = sampson(sights, i, j, a, b)
    mutual = (off[a, b] < NEAR) & (off.argmin(axis=1)[a] == b) & (off.argmin(axis=0)[b] == a)
    tracks: NDArray[np.intp] = np.full((int(mutual.sum()), len(sights.views)), -1, np.intp)
    tracks[:, i], tracks[:, j] = a[mutual], b[mutual]
    good = places_of(sights, tracks, sights.kind[i, tracks[:, i]]).good
    return [
        {sights.views[i].id: sights.ids[i][row[i]], sights.views[j].id: sights.ids[j][row[j]]}
        for row in tracks[good].tolist()
    ]
