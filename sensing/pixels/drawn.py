"""A painted mesh drawn alone at a pose: its colours, depth and facing, before nothing.

* ``Paint(mesh)``: ready to be drawn at any pose, ``Paint(mesh).drawn(pose, K, (width, height))``
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.bodies.resting import hull_corners
from geometry.frames import inverse, transform_points
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import extent
from sensing.simulated.raycast import STEEPEST, Caster

NEAR = 0.02
"""Diameters: what is nearer to the camera than this is not drawn."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """One picture (h, w) of a mesh.

    ``colour`` (h, w, 3) float32, blue first, 0 where it is not; ``depth`` (h, w) metres along the optical axis, inf
    where it is not; ``normal`` (h, w, 3) unit, camera's frame, 0 where it is not.
    """

    colour: NDArray[np.float32]
    depth: Floats
    normal: Floats

    @property
    def mask(self) -> Mask:
        """(h, w) where the mesh is."""
        return np.asarray(np.isfinite(self.depth))


class Paint:
    """A painted mesh with its rays, in its own frame; ``middle`` (3,) of its box, ``diameter`` of the ball about it."""

    def __init__(self, mesh: TexturedMesh) -> None:
        """Build its acceleration structure and the pyramid of its texture."""
        self.mesh = mesh
        self.middle, self.diameter = extent(mesh.vertices)
        self._caster = Caster([Body(None, mesh, np.eye(4))])
        self._outer = hull_corners(mesh.vertices)

    def box(self, pose: Floats, K: Floats) -> Floats | None:
        """(2, 2) least and greatest pixel (u, v) of its vertices at a pose (4, 4); None where some are too near."""
        placed = transform_points(pose, self._outer)
        if placed[:, 2].min() < NEAR * self.diameter:
            return None
        uv = placed[:, :2] / placed[:, 2:] * np.diag(K)[:2] + K[:2, 2]
        return np.array([uv.min(axis=0), uv.max(axis=0)])

    def drawn(self, pose: Floats, K: Floats, size: tuple[int, int]) -> Drawn:
        """The picture, ``size`` wide and high, of the mesh at camera_from_object (4, 4), no lens in between."""
        width, height = size
        result = Drawn(
            np.zeros((height, width, 3), np.float32), np.full((height, width), np.inf), np.zeros((height, width, 3))
        )
        box = self.box(pose, K)
        if box is None:
            return result
        low = np.maximum(np.floor(box[0]), 0).astype(int)
        high = np.minimum(np.ceil(box[1]) + 1, [width, height]).astype(int)
        if (high <= low).any():
            return result
        u, v = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
        rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones(u.shape)], axis=-1).reshape(-1, 3)
        found = self._caster.cast(inverse(pose)[:3, 3], rays @ pose[:3, :3])
        normal = found.normal @ pose[:3, :3].T
        steep = np.abs((normal * rays).sum(axis=1)) / np.linalg.norm(rays, axis=1)
        hit = found.body >= 0
        colours = self._caster.colours(found, np.where(hit, found.depth, 1.0) / K[0, 0], np.maximum(steep, STEEPEST))
        window = slice(low[1], high[1]), slice(low[0], high[0])
        result.colour[window] = colours.reshape(*u.shape, 3)
        result.depth[window] = np.where(hit, found.depth, np.inf).reshape(u.shape)
        result.normal[window] = normal.reshape(*u.shape, 3)
        return result
