"""Which sights poses show: those whose lobe holds the viewpoint, of features that a cell near it shows.

* ``shown(index, kind, poses)``: the sights of any number of poses, one after the other
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kb.clouds.lobes import GRAIN
from plogic.match.gamma.ideal_projection import viewpoints_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.oriented.pair_index import PairIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

NEAR = 3
"""Cells about a viewpoint: what any of them shows is shown, if its lobe holds the viewpoint; what a cell shows, a lobe
holds there."""


class Shown(NamedTuple):
    """S sights: ``pose`` (S,) which pose shows it, in order; ``feature`` (S,) whose it is; ``looks`` (S,) number of its appearance type."""

    pose: Indices
    feature: Indices
    looks: Indices


def shown(index: PairIndex, kind: Indices, poses: Floats) -> Shown:
    """The sights of poses (N, 4, 4) of types ``kind`` (N,)."""
    views = viewpoints_of(poses)
    along = (views - index.centres[kind]) @ index.cells[0].directions.T
    cells = np.argpartition(-along, NEAR - 1, axis=1)[:, :NEAR]
    lobes = index.lobes
    seen = np.zeros((len(kind), lobes.feature.shape[1]), bool)
    for one in np.unique(kind):
        rows, count = np.flatnonzero(kind == one), lobes.own[one]
        visible = index.cells[one].visible[cells[rows]].any(axis=1)
        seen[rows, :count] = visible[:, lobes.feature[one, :count]]
    pose, lobe = np.nonzero(seen)
    own = kind[pose], lobe
    feature = lobes.feature[own]
    view = views[pose] - index.points[kind[pose], feature]
    held = (view * lobes.axis[own]).sum(axis=1) >= lobes.cos_half[own] * np.linalg.norm(view, axis=1) - GRAIN
    return Shown(pose[held], feature[held], lobes.looks[own][held])
