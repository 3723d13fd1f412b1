"""The nearest place on triangles to a point."""

import numpy as np

from geometry.arrays import Floats


def nearest_places(corners: Floats, place: Floats) -> Floats:
    """Of each triangle of `corners` (T, 3, 3) the place (T, 3) that is nearest to `place` (3,): in its inside, or on an edge."""
    sides = np.roll(corners, -1, axis=1) - corners
    length = (sides**2).sum(axis=2)
    share = np.clip(((place - corners) * sides).sum(axis=2) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    on_edges = corners + share[..., None] * sides
    best = ((on_edges - place) ** 2).sum(axis=2).argmin(axis=1)
    found = np.take_along_axis(on_edges, best[:, None, None], axis=1)[:, 0]
    normal = np.cross(sides[:, 0], sides[:, 1])
    area = (normal**2).sum(axis=1)
    foot = place - (((place - corners[:, 0]) * normal).sum(axis=1) / np.where(area > 0.0, area, 1.0))[:, None] * normal
    turns = (np.cross(sides, foot[:, None] - corners) * normal[:, None]).sum(axis=2)
    return np.where(((turns >= 0.0).all(axis=1) & (area > 0.0))[:, None], foot, found)
