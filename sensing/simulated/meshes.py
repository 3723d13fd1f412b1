"""Mesh files for the simulated camera: OBJ with its MTL and PNG, or whatever else trimesh reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensing.errors import SceneError
from sensing.images import read_image
from sensing.simulated.body import TexturedMesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

GREY = (0.75, 0.75, 0.75)
"""The colour of a mesh that brings none."""


def read_mesh(path: str | Path, metres_per_unit: float = 1.0) -> TexturedMesh:
    """Read a painted mesh; no mesh format carries its unit, so it is given.

    Raises:
        SceneError: The file cannot be read as a triangle mesh.
        ImageError: Its texture cannot be read.
    """
    import trimesh

    path = Path(path)
    if not path.is_file():
        raise SceneError(f"{path}: there is no such mesh file")
    try:
        mesh: Any = trimesh.load(path, force="mesh", process=False)
    except Exception as error:
        raise SceneError(f"{path}: trimesh cannot read it: {error}") from error
    texture = _texture(mesh, path)
    uv = getattr(mesh.visual, "uv", None) if texture is not None else None
    if uv is None or len(uv) != len(mesh.vertices):
        return TexturedMesh(np.asarray(mesh.vertices) * metres_per_unit, np.asarray(mesh.faces), colour=GREY)
    return TexturedMesh(np.asarray(mesh.vertices) * metres_per_unit, np.asarray(mesh.faces), np.asarray(uv), texture)


def _texture(mesh: Any, path: Path) -> NDArray[np.uint8] | None:  # noqa: ANN401 - trimesh is untyped
    """The texture that the file names (OBJ: through its MTL) or carries inside (GLB and the like); None where there is none."""
    if path.suffix.lower() == ".obj":
        named = _named_by_obj(path)
        return None if named is None else read_image(named)
    material = getattr(mesh.visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    return None if image is None else np.ascontiguousarray(np.asarray(image.convert("RGB"))[:, :, ::-1])


def _named_by_obj(path: Path) -> Path | None:
    for library in _values(path, "mtllib"):
        if (path.parent / library).is_file():
            for name in _values(path.parent / library, "map_Kd"):
                return path.parent / name
    return None


def _values(path: Path, key: str) -> list[str]:
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return [line.split(maxsplit=1)[1].strip() for line in lines if line.split()[:1] == [key] and len(line.split()) > 1]
