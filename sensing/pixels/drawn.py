"""A painted mesh drawn alone at a pose: its colours, depth and facing, before nothing.

* ``Paint(mesh)``: ready to be drawn at any pose, ``Paint(mesh).drawn(pose, K, (width, height))``
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.bodies.resting import hull_corners
from geometry.frames import inverse, transform_points
from sensing.pixels.painting import nearest_facets, paint, sights
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import extent
from sensing.simulated.raycast import Caster

NEAR = 0.02
"""Diameters: what is nearer to the camera than this is not drawn."""
MANY = 20000
"""Triangles from which on rays find faster what a pixel shows: 8,000 pixels take them 0.7 ms, and triangles 0.04 ms a
thousand."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """One picture (h, w) of a mesh.

    ``colour`` (h, w, 3) float32, blue first, 0 where it is not; ``depth`` (h, w) metres along the optical axis, inf
    where it is not; ``normal`` (h, w, 3) float32, unit, camera's frame, 0 where it is not.
    """

    colour: NDArray[np.float32]
    depth: Floats
    normal: NDArray[np.float32]

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
        self._facets, self._pyramid = self._caster.facets, self._caster.paints[0].flat
        corners, own = np.unique(mesh.vertices, axis=0, return_inverse=True)
        self._corners, self._triangles = np.array(corners, float), np.reshape(own, -1)[mesh.triangles]
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
            np.zeros((height, width, 3), np.float32),
            np.full((height, width), np.inf),
            np.zeros((height, width, 3), np.float32),
        )
        box = self.box(pose, K)
        if box is None:
            return result
        low = np.maximum(np.floor(box[0]), 0).astype(int)
        high = np.minimum(np.ceil(box[1]) + 1, [width, height]).astype(int)
        if (high <= low).any():
            return result
        view = np.array(K, float, order="C"), np.array(pose[:3, :3], float, order="C"), inverse(pose)[:3, 3].copy()
        if len(self._triangles) > MANY:
            met = self._caster.mesh.seen_from(view[2], sights(low, high, view))
        else:
            met = nearest_facets(low, high, view, self._corners, self._triangles)
        picture = result.colour, result.depth, result.normal
        paint(met, low, int(high[0] - low[0]), view, self._facets, self._pyramid, picture)
        return result
