"""Physical features into unknown objects: near each other, by their own spacing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.sequence.constancy.company import spacing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.intp]

REACH = 2.0
"""Two features are of one object where they are nearer than so many spacings (the median distance to a third
neighbour), or linked by others."""


def clusters(at: Floats) -> list[Ints]:
    """Indices of places (N, 3) m, an array a cluster: the largest first, of equally large ones that with the first place."""
    from scipy.cluster.hierarchy import fcluster, linkage

    if len(at) < 2:
        return [np.arange(len(at))] if len(at) else []
    labels = fcluster(linkage(at, "single"), REACH * spacing(at), "distance")
    groups = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    return sorted(groups, key=lambda group: (-len(group), int(group[0])))
