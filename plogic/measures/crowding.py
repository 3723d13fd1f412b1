"""What stands together in the image comes from the same print, and what stands along one line from the same edge: found or missed together."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CROWDED = 3.0
"""Pixels (standard deviation) within which expected features of a learned type are found or missed together."""
ALONG, BENT = 10.0, 0.2
"""The same along a line across which both turn, pixels, and how much they may differ in that, radians: one line of
clutter is right for all."""


LINKED = 0.4
"""How much of that holds where one of the two is the side of an edge: of those that lie along one line of clutter so
large a share is found together, as the correlation over development scenes says."""


def shares(uv: Floats, turn: Floats, sided: NDArray[np.bool_]) -> Floats:
    """(N,) for how much of an independent observation each of N features counts: one over those that go with it, itself included.

    ``uv`` (N, 2) pixels; ``turn`` (N,) radians, the screen angle of what is seen of each, across its edge; ``sided``
    (N,) which are sides.
    """
    from scipy.spatial import cKDTree

    one, other = cKDTree(uv).query_pairs(3.0 * max(ALONG, CROWDED), output_type="ndarray").T
    apart, bent = uv[other] - uv[one], (turn[other] - turn[one] + np.pi / 2) % np.pi - np.pi / 2
    mean = turn[one] + bent / 2.0
    across = apart[:, 0] * np.cos(mean) + apart[:, 1] * np.sin(mean)
    square = (apart**2).sum(axis=1)
    crowd = np.exp(-0.5 * square / CROWDED**2)
    line = np.exp(-0.5 * ((across / CROWDED) ** 2 + (square - across**2) / ALONG**2 + (bent / BENT) ** 2))
    linked = np.where(sided[one] | sided[other], LINKED, 1.0) * np.maximum(crowd, line)
    together = np.bincount(np.concatenate([one, other]), np.tile(linked, 2), len(uv))
    return np.asarray(1.0 / (1.0 + together))
