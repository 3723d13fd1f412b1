"""How far points are from a surface, by its nearest triangles."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints

SPOTS = 40_000
"""Points laid over the surface, through which its near triangles are found."""
NEAR = 12
"""Spots looked at for each point."""
SLIVER = 20
"""Most spots that a triangle gets for its length alone."""


class Nearness:
    """A surface ready to be asked how far points are.

    Never too near, and too far by no more than the spots are apart.
    """

    def __init__(self, vertices: Floats, triangles: Ints) -> None:
        from scipy.spatial import cKDTree

        self._corners = vertices[triangles]
        spots, self._owner = spread(vertices, triangles, SPOTS)
        self._tree = cKDTree(spots)

    def distance(self, points: Floats) -> Floats:
        """(N,) m from each of ``points`` (N, 3) to the surface."""
        _, found = self._tree.query(points, k=NEAR)
        corners = self._corners[self._owner[found]]
        return np.asarray(np.sqrt(_squared(points[:, None], corners).min(axis=1)))


def spread(vertices: Floats, triangles: Ints, count: int) -> tuple[Floats, NDArray[np.intp]]:
    """About ``count`` points (N, 3) over the surface, and whose they are.

    Evenly by area, along slivers, and at least one in the middle of each triangle.
    """
    corners = vertices[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    even = areas / max(areas.sum(), 1e-300) * count
    along = np.minimum(longest / max(np.sqrt(areas.sum() / count), 1e-300), SLIVER)
    shares = np.maximum(1, np.floor(np.maximum(even, along))).astype(int)
    owner = np.repeat(np.arange(len(triangles)), shares)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(shares) - shares, shares)
    u, v = np.modf((number + 0.5) * 0.7548776662466927)[0], np.modf((number + 0.5) * 0.5698402909980532)[0]
    over = u + v > 1
    u, v = np.where(over, 1 - u, u), np.where(over, 1 - v, v)
    single = shares[owner] == 1
    u, v = np.where(single, 1 / 3, u), np.where(single, 1 / 3, v)
    a, b, c = np.moveaxis(corners[owner], 1, 0)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a), owner


def _squared(points: Floats, corners: Floats) -> Floats:
    """Squared distance from points (N, 1, 3) to triangles (N, K, 3, 3).

    To the plane where its foot is inside, else to the nearest side.
    """
    a, b, c = np.moveaxis(corners, 2, 0)
    normal = np.cross(b - a, c - a)
    size = (normal**2).sum(axis=-1)
    height = ((points - a) * normal).sum(axis=-1)
    inside = size > 0
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(end - start, points - start) * normal).sum(axis=-1) >= 0
    sides = np.min([_to_side(points, start, end) for start, end in ((a, b), (b, c), (c, a))], axis=0)
    return np.where(inside, np.divide(height**2, size, out=np.zeros_like(size), where=size > 0), sides)


def _to_side(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    size = (along**2).sum(axis=-1)
    share = np.divide(((points - start) * along).sum(axis=-1), size, out=np.zeros_like(size), where=size > 0)
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.asarray(((points - foot) ** 2).sum(axis=-1))
