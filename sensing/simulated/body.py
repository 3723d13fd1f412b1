"""What stands before the simulated camera.

* ``TexturedMesh``: a surface with its paint, ``TexturedMesh(vertices, triangles, uv=uv, texture=bgr)``
* ``Body``: such a mesh somewhere in the world, ``Body("crate", mesh, world_from_body)``

``read_mesh`` reads whatever trimesh does, with the texture that the file names (OBJ, PLY) or carries (GLB).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.files.mesh_files import Placed, Texture, joined_meshes, meshes_of, reason, textures_in, triangles_of
from geometry.files.plain_files import IS_MISSING, fault_of
from sensing.errors import SceneError
from sensing.files.images import image_from, read_image


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


GREY = (0.75, 0.75, 0.75)
"""The colour of a mesh that brings none."""
ONE = "a mesh that is rendered has one picture for all of it: plogic kb add makes it of several"


def read_mesh(path: str | Path, metres_per_unit: float = 1.0) -> TexturedMesh:
    """Read a painted mesh; no mesh format carries its unit, so it is given.

    Raises:
        SceneError: The file cannot be read as a triangle mesh, or it has several textures.
        ImageError: Its texture cannot be read.
    """
    path = Path(path)
    fault = fault_of(path)
    if fault is not None:
        raise SceneError(f"{path}: there is no such mesh file" if fault == IS_MISSING else f"{path}: {fault}")
    try:
        meshes = [(mesh, placed) for mesh, placed in meshes_of(path) if len(mesh.faces)]
    except Exception as error:
        raise SceneError(f"{path}: trimesh cannot read it: {reason(path, error)}") from error
    if not meshes:
        raise SceneError(f"{path}: holds no triangles")
    vertices, triangles = joined_meshes([triangles_of(mesh, placed) for mesh, placed in meshes])
    uv = _uv(meshes)
    texture = _texture(path, meshes) if uv is not None else None
    if texture is None:
        return TexturedMesh(vertices * metres_per_unit, triangles, colour=GREY)
    return TexturedMesh(vertices * metres_per_unit, triangles, uv, texture)


def _uv(meshes: Placed) -> NDArray[np.float64] | None:
    """(V, 2); None where a vertex has none."""
    rows = [getattr(mesh.visual, "uv", None) for mesh, _ in meshes]
    complete = all(uv is not None and len(uv) == len(mesh.vertices) for uv, (mesh, _) in zip(rows, meshes, strict=True))
    return np.concatenate([np.asarray(uv, dtype=np.float64) for uv in rows]) if complete else None


def _texture(path: Path, meshes: Placed) -> NDArray[np.uint8] | None:
    """The one texture, (H, W, 3), blue first; None where there is none."""
    found = textures_in(path)[0]
    if (
        len(found) > 1 or path.suffix.lower() != ".obj"
    ):  # the one picture of an OBJ paints all of it, whatever its materials are called
        found = _used(found, meshes, path)
    if not found:
        return None
    first = found[0]
    if first.file is not None:
        return read_image(first.file)
    if first.data is None:
        raise SceneError(f"{path}: the {first.label} {first.fault or 'is missing'}")
    return image_from(first.data, f"{path}: the {first.label}")


def _used(found: list[Texture], meshes: Placed, path: Path) -> list[Texture]:
    """The one texture that all the meshes have, none where none has one. Raises SceneError where they differ."""
    known = {texture.material: texture for texture in found}
    own = [known.get(_material(mesh), known.get("")) for mesh, _ in meshes]
    different = {(texture.file, texture.data) for texture in own if texture is not None}
    if len(different) > 1:
        raise SceneError(f"{path}: has {len(different)} textures; {ONE}")
    if different and None in own:
        raise SceneError(f"{path}: only {len(own) - own.count(None)} of its {len(own)} pieces have a texture; {ONE}")
    return [texture for texture in own if texture is not None][:1]


def _material(mesh: Any) -> str:  # noqa: ANN401 - trimesh is untyped
    return str(getattr(getattr(mesh.visual, "material", None), "name", ""))
