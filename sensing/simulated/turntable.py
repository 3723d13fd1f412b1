"""Pictures of one body alone from all around, evenly lit, as learning a type looks at it.

* ``Turn``: one large picture with its depth, ``Turn(image, mask, depth, camera, pixels=580.0)``
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from sensing.simulated.body import TexturedMesh
from sensing.simulated.camera import extent
from sensing.simulated.raycast import STEEPEST, paint_of, texels_per_metre

FINER = 2
"""Pictures are drawn so many times larger than the largest that is needed; a texture is smooth at any size. A view of a
box takes 6 ms, at 3 12 ms (pybullet: 60 ms)."""
FAR = 20.0
"""Distances of the viewpoint: how far away nothing is."""
POLAR = 0.95
"""Cosine to the z axis from which on another axis is up in the picture."""


@dataclass(frozen=True, eq=False)
class Turn:
    """One picture of the body before nothing.

    ``image`` (H, W, 3) uint8, blue first; ``mask`` (H, W) where the body is; ``depth`` (H, W) metres along the optical
    axis, far away elsewhere; ``camera``, whose ``world_from_camera`` is body_from_camera; ``pixels``: the body's
    diameter in the picture.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32]
    camera: Camera
    pixels: float


def turned(
    mesh: TexturedMesh, viewpoints: Sequence[NDArray[np.float64]], pixels: float, margin: float, away: float
) -> Iterator[Turn]:
    """One picture a direction (3,) from the middle of the mesh's box.

    ``pixels``: the body's diameter, of which pictures are ``FINER`` times as many; ``margin``: what is left around the
    body, and ``away``: the viewpoint's distance, both in diameters.
    """
    middle, diameter = extent(mesh.vertices)
    drawer = _Drawer(mesh, diameter)
    for direction in viewpoints:
        upward = (0.0, 0.0, 1.0) if abs(direction[2]) < POLAR else (0.0, 1.0, 0.0)
        camera_from_body = look_at(middle + np.asarray(direction, float) * away * diameter, middle, upward)
        yield drawer.drawn(camera_from_body, pixels * FINER, margin, away)


class _Drawer:
    """A mesh with its texture's copies laid out for the loops."""

    def __init__(self, mesh: TexturedMesh, diameter: float) -> None:
        self._mesh, self._diameter, paint = mesh, diameter, paint_of(mesh)
        self._uv = np.zeros((len(mesh.triangles), 3, 2)) if mesh.uv is None else mesh.uv[mesh.triangles]
        self._texels = np.concatenate([level.reshape(-1, 3) for level in paint.levels])
        shapes = np.array([level.shape[:2] for level in paint.levels])
        ends = np.cumsum(shapes.prod(axis=1))
        self._sizes = np.column_stack([ends - shapes.prod(axis=1), shapes])
        self._fine = texels_per_metre(mesh.corners, self._uv, np.tile(paint.size, (len(mesh.triangles), 1)))

    def drawn(self, camera_from_body: NDArray[np.float64], pixels: float, margin: float, away: float) -> Turn:
        """The body, of a diameter of so many pixels, and the margin."""
        from sensing.simulated.raster import filled

        vertices = transform_points(camera_from_body, self._mesh.vertices)
        f, corners = pixels * away, vertices[self._mesh.triangles]
        spot = vertices[:, :2] / vertices[:, 2:] * f
        low = np.ceil(spot.min(axis=0)) - round(margin * pixels)
        width, height = (np.floor(spot.max(axis=0)) + round(margin * pixels) - low).astype(int) + 1
        K = np.array([[f, 0.0, -low[0]], [0.0, f, -low[1]], [0.0, 0.0, 1.0]])
        camera = Camera(int(width), int(height), K, np.zeros(0), inverse(camera_from_body))
        middle, normal = corners.mean(axis=1), self._mesh.normals @ camera_from_body[:3, :3].T
        steep = np.abs((normal * middle).sum(axis=1)) / np.linalg.norm(middle, axis=1)
        footprint = self._fine * middle[:, 2] / f / np.sqrt(np.maximum(steep, STEEPEST))
        level = np.clip(np.rint(np.log2(np.maximum(footprint, 1e-9))), 0, len(self._sizes) - 1).astype(np.int64)
        image, near = filled(
            (spot - low)[self._mesh.triangles],
            corners[..., 2],
            self._uv,
            level,
            self._texels,
            self._sizes,
            (int(height), int(width)),
        )
        mask = near > 0.0
        far = np.float32(1.0 / (FAR * away * self._diameter))
        return Turn(image, mask, np.asarray(1.0 / np.where(mask, near, far), np.float32), camera, pixels)
