"""What stands before the simulated camera.

* ``TexturedMesh``: a surface with its paint, ``TexturedMesh(vertices, triangles, uv=uv, texture=bgr)``
* ``Body``: such a mesh somewhere in the world, ``Body("crate", mesh, world_from_body)``
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensing.errors import SceneError


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """A painted triangle mesh.

    Attributes:
        vertices: (V, 3) metres, body frame.
        triangles: (T, 3) indices, counter-clockwise seen from outside.
        uv: (V, 2) texture coordinates, (0, 0) at the lower left of the texture; None with a plain colour.
        texture: (H, W, 3) uint8, blue first; None for a plain colour.
        colour: Red, green, blue in [0, 1]; multiplies the texture.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None
    texture: NDArray[np.uint8] | None = None
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        _freeze(self, "vertices", (-1, 3), np.float64)
        _freeze(self, "triangles", (-1, 3), np.int64)
        if self.uv is not None:
            _freeze(self, "uv", (-1, 2), np.float64)
            if len(self.uv) != len(self.vertices):
                raise SceneError(f"mesh: {len(self.uv)} texture coordinates for {len(self.vertices)} vertices")
        if not len(self.triangles):
            raise SceneError("mesh: has no triangle")
        if (
            not np.isfinite(self.vertices).all()
            or self.triangles.min() < 0
            or self.triangles.max() >= len(self.vertices)
        ):
            raise SceneError("mesh: a vertex is not finite, or a triangle names a vertex that is not there")

    @property
    def corners(self) -> NDArray[np.float64]:
        """(T, 3, 3): the three vertices of each triangle, metres, body frame."""
        return self.vertices[self.triangles]

    @property
    def normals(self) -> NDArray[np.float64]:
        """(T, 3) unit outward normals, body frame; a degenerate triangle's is (0, 0, 0)."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        n = np.cross(b - a, c - a)
        return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-15)


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh at ``world_from_body`` (4, 4).

    ``label`` names it in the ground truth and nowhere else, None for an untyped decoy.
    """

    label: str | None
    mesh: TexturedMesh
    world_from_body: NDArray[np.float64]

    def __post_init__(self) -> None:
        _freeze(self, "world_from_body", (4, 4), np.float64)

    @property
    def vertices_world(self) -> NDArray[np.float64]:
        """(V, 3) metres, world frame."""
        return self.mesh.vertices @ self.world_from_body[:3, :3].T + self.world_from_body[:3, 3]


def _freeze(holder: object, name: str, shape: tuple[int, ...], dtype: type) -> None:
    try:
        array: NDArray[Any] = np.array(getattr(holder, name), dtype=dtype).reshape(shape)
    except ValueError as error:
        raise SceneError(f"{name}: {error}") from None
    array.setflags(write=False)
    object.__setattr__(holder, name, array)
