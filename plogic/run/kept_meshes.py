"""Painted meshes that were read before: to read one again takes trimesh, SciPy and networkx, longer than to draw it.

* ``mesh_of(kind)``: ``read_mesh`` of the mesh that a type is rendered with
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geometry.files.plain_files import content_of
from geometry.files.remembered import arrays_of, cache_folder
from kb.clouds.cloud import ObjectType
from kb.files.folder import MAX_MESH_BYTES
from kb.files.kept_surfaces import mesh_key, read_by
from plogic.base.errors import InputError
from sensing.errors import SensingError
from sensing.simulated.body import TexturedMesh, read_mesh

SOURCES = "geometry", "sensing/errors.py", "sensing/files", "sensing/simulated/body.py"
LIBRARIES = "numpy", "opencv-python-headless", "trimesh"
"""What reads a painted mesh."""
KEPT = 64
"""Meshes that are kept; those used last."""
NAMES = "vertices", "triangles", "uv", "texture", "colour"


def mesh_of(kind: ObjectType) -> TexturedMesh:
    """The mesh that a type is rendered with, metres, body frame.

    Raises InputError where it has none; SceneError and ImageError as ``read_mesh`` does.
    """
    if kind.mesh_file is None:
        raise InputError(f"{kind.name}: has no mesh, so that it cannot be rendered")
    folder = cache_folder("meshes")
    try:
        content = content_of(kind.mesh_file, MAX_MESH_BYTES, SensingError)
    except SensingError:  # it says better why
        folder = None
    return read_mesh(kind.mesh_file, kind.mesh_scale) if folder is None else _kept(kind, content, folder)


def _kept(kind: ObjectType, content: bytes, folder: Path) -> TexturedMesh:
    file, scale = Path(kind.mesh_file or ""), kind.mesh_scale

    def read() -> dict[str, NDArray[np.generic]]:
        mesh = read_mesh(file, scale)
        uv = np.zeros((0, 2)) if mesh.uv is None else mesh.uv
        texture = np.zeros((0, 0, 3), np.uint8) if mesh.texture is None else mesh.texture
        return dict(zip(NAMES, (mesh.vertices, mesh.triangles, uv, texture, np.array(mesh.colour)), strict=True))

    key = mesh_key(file, content, scale, read_by(LIBRARIES, SOURCES), pictures=True)
    arrays = arrays_of(folder / key, NAMES, read, KEPT)
    vertices, triangles, uv, texture, (red, green, blue) = (np.array(arrays[name]) for name in NAMES)
    return TexturedMesh(
        vertices,
        triangles,
        uv if len(uv) else None,
        texture if len(texture) else None,
        (float(red), float(green), float(blue)),
    )
