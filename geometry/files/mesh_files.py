"""The triangle meshes of a file as trimesh reads them, each at its place in the file's scene.

Their pictures are in ``mesh_textures``.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.files.plain_files import fault_of, is_there

Placed = list[tuple[Any, "NDArray[np.float64]"]]
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".webp", ".tif", ".tiff", ".tga", ".gif")


def meshes_of(path: Path) -> Placed:
    """Every ``trimesh.Trimesh`` of the file with ``file_from_mesh`` (4, 4), which may scale and mirror.

    Nothing is merged or copied.

    Raises whatever trimesh's readers raise, which is anything; ``reason`` puts it into words.
    """
    import trimesh

    scene: Any = trimesh.load_scene(path, process=False, resolver=beside(path))
    order = {name: index for index, name in enumerate(scene.geometry)}  # the graph's own order changes from run to run
    nodes = sorted(
        (order[name], str(node), name, placed)
        for node in scene.graph.nodes_geometry
        for placed, name in [scene.graph[node]]
    )
    meshes = [(scene.geometry[name], np.asarray(placed, dtype=np.float64)) for _, _, name, placed in nodes]
    return [(mesh, placed) for mesh, placed in meshes if isinstance(mesh, trimesh.Trimesh)]


def beside(path: Path) -> Any:  # noqa: ANN401 - trimesh's "resolver"
    """What a mesh file names beside it, for trimesh: its materials and buffers, plain files alone.

    Of its pictures nothing is asked.
    """
    return _Beside(path)


class _Beside:
    def __init__(self, path: Path) -> None:
        from trimesh.resolvers import FilePathResolver

        self.folder, self.files = path.parent, FilePathResolver(str(path))
        self.file_name = path.name

    def get(self, name: str) -> bytes:
        place = self.folder / name.strip()
        if name.strip().lower().endswith(PICTURES) or (is_there(place) and fault_of(place) is not None):
            raise FileNotFoundError(name)
        return self.files.get(name)

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)


def reason(path: Path, error: Exception) -> str:
    """Why trimesh could not read a mesh file, in one line of at most 200 characters."""
    if isinstance(error, ModuleNotFoundError) and error.name == "charset_normalizer":
        return "it holds bytes that are no text in UTF-8"
    if isinstance(error, ModuleNotFoundError):
        return f"reading it needs the package {error.name}, or convert the mesh to OBJ or GLB"
    if path.suffix.lower() == ".gltf" and isinstance(error, LookupError | OSError | RecursionError):
        return "it is no glTF 2.0, or a buffer that it names is missing"
    return " ".join(str(error).split())[:200] or type(error).__name__


def triangles_of(mesh: Any, file_from_mesh: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:  # noqa: ANN401 - trimesh's
    """Vertices (V, 3) in the file's frame and triangles (T, 3), turned over where the placing mirrors."""
    vertices, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
    if not np.array_equal(file_from_mesh, np.eye(4)):
        vertices = vertices @ file_from_mesh[:3, :3].T + file_from_mesh[:3, 3]
        if np.linalg.det(file_from_mesh[:3, :3]) < 0:
            triangles = triangles[:, ::-1].copy()
    return vertices, triangles
