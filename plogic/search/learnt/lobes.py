"""Which lobes of a learnt type hold a viewpoint, or nearly do (§2.7): of thousands of them, at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse
from plogic.search.learnt.agreement import ASIDE, GRAZING

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.learnt.index import LearntIndex

    Floats = NDArray[np.float64]


def held_from(index: LearntIndex, viewpoints: Floats, granularity: float) -> NDArray[np.bool_]:
    """(H, L) whether each lobe holds each viewpoint (H, 3), object frame; ``granularity``: f over that at which ranges are told."""
    along, distance = index.seen_from(viewpoints)
    cloud, scale = index.cloud, np.float32(granularity)
    near, far = cloud.r_min.astype(np.float32) * scale, cloud.r_max.astype(np.float32) * scale
    return np.asarray((along >= index.cos_half * distance) & (distance >= near) & (distance <= far))


def lobes_about(index: LearntIndex, pose: Floats) -> NDArray[np.intp]:
    """Indices of the lobes of keypoints that hold the viewpoint, or would if they were wider by ``ASIDE``."""
    along, distance = index.seen_from(inverse(pose)[None, :3, 3])
    wide = np.cos(np.minimum(index.cloud.half_angle + ASIDE, GRAZING)).astype(np.float32)
    return np.flatnonzero((along[0] >= wide * distance[0]) & ~index.cloud.sided)
