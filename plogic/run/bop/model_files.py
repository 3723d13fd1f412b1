"""A model as BOP wants it: ``obj_000001.ply`` in millimetres with normals (and texture), and its entry in ``models_info.json``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.run.bop.json_files import MM

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sensing.simulated.body import TexturedMesh


@dataclass(frozen=True, eq=False)
class Kind:
    """One type that scenes are made of: ``label`` of its bodies, its mesh, metres, and ``symmetries`` (S, 4, 4), a group."""

    label: str
    mesh: TexturedMesh
    symmetries: NDArray[np.float64] = field(default_factory=lambda: np.eye(4)[None])


def ply(mesh: TexturedMesh, texture: str | None) -> bytes:
    """Binary PLY, millimetres; ``texture`` names the image beside it, for a mesh with texture coordinates."""
    columns = [mesh.vertices * MM, vertex_normals(mesh)]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    if texture is not None and mesh.uv is not None:
        columns, names = [*columns, mesh.uv], [*names, "texture_u", "texture_v"]
    faces = np.empty(len(mesh.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.triangles
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *([f"comment TextureFile {texture}"] if texture is not None else []),
    ]
    header += [f"element vertex {len(mesh.vertices)}", *(f"property float {name}" for name in names)]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join([*header, ""]).encode() + np.hstack(columns).astype("<f4").tobytes() + faces.tobytes()


def vertex_normals(mesh: TexturedMesh) -> NDArray[np.float64]:
    """(V, 3) unit: the mean of the normals of the triangles at each vertex, by their area; (0, 0, 1) where no triangle is."""
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    sums = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(sums, mesh.triangles[:, corner], np.cross(b - a, c - a))
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 0, sums / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))


def model_info(kind: Kind) -> dict[str, Any]:
    """The entry of ``models_info.json``: diameter, box and symmetries, millimetres."""
    low, high = kind.mesh.vertices.min(axis=0) * MM, kind.mesh.vertices.max(axis=0) * MM
    box = {f"min_{axis}": float(low[i]) for i, axis in enumerate("xyz")} | {
        f"size_{axis}": float(high[i] - low[i]) for i, axis in enumerate("xyz")
    }
    return {"diameter": diameter(kind.mesh.vertices) * MM} | box | _symmetries(kind.symmetries)


def diameter(points: NDArray[np.float64]) -> float:
    """The largest distance between two of ``points`` (N, 3): two corners of their hull."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:  # flat
        corners = np.unique(points, axis=0)
    return float(np.sqrt(max(((corners[i:] - corner) ** 2).sum(axis=1).max() for i, corner in enumerate(corners))))


def _symmetries(group: NDArray[np.float64]) -> dict[str, Any]:
    """One axis where the group is the KB's stand-in for all turns about it; else every motion but the identity."""
    from kb.surfaces.symmetries import CONTINUOUS, symmetry_entries

    entries = symmetry_entries(group)
    if len(entries) == 1 and entries[0].get("fold") == CONTINUOUS:
        return {"symmetries_continuous": [{"axis": entries[0]["axis"], "offset": [0.0, 0.0, 0.0]}]}
    scaled = np.array(group, dtype=np.float64)
    scaled[:, :3, 3] *= MM
    others = [motion.ravel().tolist() for motion in scaled if np.abs(motion - np.eye(4)).max() > 1e-9]
    return {"symmetries_discrete": others} if others else {}
