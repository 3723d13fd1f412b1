"""What an interpretation carries along to be looked at: the image and the meshes, up to a stated size."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType
    from plogic.facts.document import AssetsRow, MeshRow

LARGEST_PNG = 768 * 2**10
"""Bytes; a larger image is carried as JPEG."""
LONGEST_SIDE = 1280
"""Pixels; a larger image is carried smaller."""
MOST_TRIANGLES = 4000
"""Of a carried mesh; a larger one is carried coarser."""
GRIDS = (80, 56, 40, 28, 20, 14, 10, 7)
"""Cells to the longest side in which a large mesh's vertices are made one, finest first, until its triangles are few
enough."""


def image_asset(image: NDArray[np.uint8] | None) -> AssetsRow:
    """``{"image": {...}}`` of a BGR picture (H, W, 3), or nothing. The size given is the original's, so that pixels keep their meaning."""
    if image is None:
        return {}
    height, width = image.shape[:2]
    shrink = LONGEST_SIDE / max(height, width)
    small = image if shrink >= 1.0 else cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    kind: Literal["image/png", "image/jpeg"]
    kind, data = "image/png", cv2.imencode(".png", small)[1]
    if data.size > LARGEST_PNG:
        kind, data = "image/jpeg", cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 88])[1]
    text = base64.b64encode(data.tobytes()).decode()
    return {"image": {"media_type": kind, "width": width, "height": height, "base64": text}}


def mesh_assets(types: Mapping[str, ObjectType]) -> AssetsRow:
    """``{"meshes": {type: {"vertices", "triangles"}}}`` in metres, object frame, to 0.1 mm; of a coarser one how far off it may be, ``slack``, m."""
    meshes: dict[str, MeshRow] = {}
    for name, object_type in sorted(types.items()):
        surface = object_type.surface
        if surface is not None:
            vertices, triangles, slack = _carried(surface.vertices, surface.triangles)
            meshes[name] = {"vertices": np.round(vertices, 4).tolist(), "triangles": triangles.tolist()}
            if slack != 0.0:
                meshes[name]["slack"] = round(slack, 5)
    return {"meshes": meshes}


def _carried(
    vertices: NDArray[np.float64], triangles: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.intp], float]:
    """The mesh, few enough triangles of it, and the diagonal of the cells that its vertices were made one in: 0 where they were not."""
    if len(triangles) <= MOST_TRIANGLES:
        return vertices, triangles, 0.0
    for cells in GRIDS:
        fewer = _clustered(vertices, triangles, cells)
        if len(fewer[1]) <= MOST_TRIANGLES:
            break
    return *fewer, float(np.sqrt(3.0) * np.ptp(vertices, axis=0).max() / cells)


def _clustered(
    vertices: NDArray[np.float64], triangles: NDArray[np.intp], cells: int
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The mesh with the vertices of each cell of a grid, ``cells`` to its longest side, made one: their mean."""
    low = vertices.min(axis=0)
    side = float((vertices.max(axis=0) - low).max()) / cells or 1.0
    _, cell = np.unique(np.floor((vertices - low) / side).astype(np.int64), axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    count = np.bincount(cell)
    means = np.stack([np.bincount(cell, vertices[:, axis]) / count for axis in range(3)], axis=1)
    faces = cell[triangles]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    first = np.unique(np.sort(faces[kept], axis=1), axis=0, return_index=True)[1]
    return means, faces[kept][np.sort(first)]
