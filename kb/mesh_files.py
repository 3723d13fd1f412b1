"""The triangle meshes of a file as trimesh reads them, each at its place in the file's scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

Placed = list[tuple[Any, "NDArray[np.float64]"]]


def meshes_of(path: Path) -> Placed:
    """Every ``trimesh.Trimesh`` of the file with ``file_from_mesh`` (4, 4), which may scale and mirror; nothing is merged or copied.

    Raises whatever trimesh's readers raise, which is anything.
    """
    import trimesh

    scene: Any = trimesh.load_scene(path, process=False)
    order = {name: index for index, name in enumerate(scene.geometry)}  # the graph's own order changes from run to run
    nodes = sorted((order[name], str(node), name, placed) for node in scene.graph.nodes_geometry for placed, name in [scene.graph[node]])
    meshes = [(scene.geometry[name], np.asarray(placed, dtype=np.float64)) for _, _, name, placed in nodes]
    return [(mesh, placed) for mesh, placed in meshes if isinstance(mesh, trimesh.Trimesh)]


def triangles_of(mesh: Any, file_from_mesh: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:  # noqa: ANN401 - trimesh's
    """Vertices (V, 3) in the file's frame and triangles (T, 3), turned over where the placing mirrors."""
    vertices, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
    if not np.array_equal(file_from_mesh, np.eye(4)):
        vertices = vertices @ file_from_mesh[:3, :3].T + file_from_mesh[:3, 3]
        if np.linalg.det(file_from_mesh[:3, :3]) < 0:
            triangles = triangles[:, ::-1].copy()
    return vertices, triangles
