"""What is drawn of a type's surface: with its texture where there is one, coarser and with a smaller picture where it is large.

A drawn mesh has *places* and *corners*: where a texture has a seam, two corners of different texture coordinates stand
at one place.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.face.pages.packed import floats, shorts
from sensing.errors import SensingError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType
    from sensing.simulated.body import TexturedMesh

MOST_TRIANGLES = 20_000
"""Of the drawn mesh, and most of its corners; a larger one is drawn coarser."""
GRIDS = (96, 72, 56, 40, 28, 20, 14, 10, 7)
"""Cells to the longest side in which a large mesh's places are made one, finest first, until what is left is small
enough."""
SEAMS = 64
"""Cells to the texture's side: corners at one place and in one of these cells are one."""
LARGEST_PICTURE = 600_000
"""Bytes of the texture as JPEG."""
SIDES = (2048, 1024, 512, 256, 128)
"""Most pixels of the texture's sides, which are powers of two, largest first, until it is small enough."""
QUALITY = 86
COARSE = 0.5
"""The page says so where the texture has less than this share of its pixels."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """``vertices`` (V, 3) m, object frame; ``triangles`` (T, 3); ``uv`` (V, 2), (0, 0) at the texture's lower left, or None."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None

    @property
    def small(self) -> bool:
        """Whether it can be carried as it is."""
        return max(len(self.triangles), len(self.vertices)) <= MOST_TRIANGLES


def surface_document(kind: ObjectType) -> tuple[dict[str, Any] | None, list[str]]:
    """The surface as plain data, None of a type without one; and what had to be left out, a sentence each."""
    if kind.surface is None:
        return None, ["It has no mesh: only its features are drawn."]
    painted, notes = _painted(kind)
    whole = Drawn(kind.surface.vertices, kind.surface.triangles)
    if painted is not None:
        whole = Drawn(painted.vertices, painted.triangles, painted.uv)
    drawn = coarser(whole)
    if len(drawn.triangles) < len(whole.triangles):
        notes.append(f"The mesh has {len(whole.triangles)} triangles; it is drawn with {len(drawn.triangles)}.")
    picture = None
    if painted is not None and painted.texture is not None:
        picture, size = _picture(painted.texture)
        height, width = painted.texture.shape[:2]
        if size[0] * size[1] < COARSE * width * height:
            notes.append(f"The texture has {width} by {height} pixels; it is drawn with {size[0]} by {size[1]}.")
    document = {
        "vertices": floats(drawn.vertices),
        "triangles": shorts(drawn.triangles),
        "uv": None if drawn.uv is None else floats(drawn.uv),
        "picture": picture,
    }
    return document, notes


def _painted(kind: ObjectType) -> tuple[TexturedMesh | None, list[str]]:
    """The textured mesh, None where there is none or it cannot be read."""
    from sensing.simulated.body import read_mesh

    if kind.mesh_file is None:
        return None, []
    try:
        mesh = read_mesh(kind.mesh_file, kind.mesh_scale)
    except SensingError as error:
        return None, [f"It is drawn without its texture: {error}."]
    return (mesh if mesh.uv is not None and np.isfinite(mesh.uv).all() else None), []


def coarser(mesh: Drawn) -> Drawn:
    """The mesh itself where it is small enough; else with places of one grid cell made one, on the finest grid that does."""
    fewer = mesh
    for cells in GRIDS if not mesh.small else ():
        fewer = _clustered(mesh, cells)
        if fewer.small:
            break
    return fewer


def _clustered(mesh: Drawn, cells: int) -> Drawn:
    low = mesh.vertices.min(axis=0)
    side = float((mesh.vertices.max(axis=0) - low).max()) / cells or 1.0
    place = _alike(np.floor((mesh.vertices - low) / side))
    corner = place if mesh.uv is None else _alike(np.column_stack([place, np.floor(mesh.uv * SEAMS)]))
    faces = place[mesh.triangles]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    once = np.sort(np.unique(np.sort(faces[kept], axis=1), axis=0, return_index=True)[1])
    triangles = corner[mesh.triangles[kept][once]]
    _, first = np.unique(corner, return_index=True)
    used, index = np.unique(triangles, return_inverse=True)
    vertices = _means(mesh.vertices, place)[place[first]][used]
    return Drawn(vertices, index.reshape(-1, 3), None if mesh.uv is None else _means(mesh.uv, corner)[used])


def _alike(rows: NDArray[Any]) -> NDArray[np.int64]:
    """(N,) the number of each row among the different ones."""
    return np.unique(rows.astype(np.int64), axis=0, return_inverse=True)[1].reshape(-1)


def _means(values: NDArray[np.float64], group: NDArray[np.int64]) -> NDArray[np.float64]:
    count = np.bincount(group)
    return np.stack([np.bincount(group, values[:, i]) / count for i in range(values.shape[1])], axis=1)


def _picture(texture: NDArray[np.uint8]) -> tuple[dict[str, str], tuple[int, int]]:
    """JPEG of a BGR texture (H, W, 3), and its width and height, powers of two so that it can repeat."""
    import cv2

    for side in SIDES:
        width, height = (min(side, 2 ** round(float(np.log2(size)))) for size in texture.shape[1::-1])
        small = texture
        if texture.shape[1::-1] != (width, height):
            small = np.asarray(cv2.resize(texture, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
        data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
        if data.size <= LARGEST_PICTURE:
            break
    return {"media_type": "image/jpeg", "base64": base64.b64encode(data.tobytes()).decode()}, (width, height)
