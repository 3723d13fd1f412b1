"""A type's surface with its texture, small enough to be carried and drawn in a page.

* ``Drawn``: a mesh with texture coordinates; ``coarser(mesh, most)`` has few enough triangles
* ``paint_assets(types)``: ``{"paints": {type: ...}}`` of an interpretation, a type at most ``LARGEST_PAINT`` bytes
  of texture and ``MOST_TRIANGLES``
"""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.files.plain_files import content_of
from geometry.files.remembered import arrays_of, cache_folder
from kb.clouds.cloud import ObjectType
from kb.files.folder import MAX_MESH_BYTES
from kb.files.kept_surfaces import mesh_key, read_by
from plogic.facts.carried_rows import AssetsRow, PaintRow, TextureRow
from plogic.run.carried import MOST_TRIANGLES, alike, cells_of, means, whole
from sensing.errors import SensingError

if TYPE_CHECKING:
    from sensing.simulated.body import TexturedMesh

LARGEST = 3e38
"""Of a number in single precision; beyond it stands this."""


def floats(values: ArrayLike) -> str:
    """In single precision, row by row."""
    return _text(np.clip(np.asarray(values, dtype=np.float64), -LARGEST, LARGEST).astype("<f4"))


def shorts(values: ArrayLike) -> str:
    """Whole numbers from 0 to 65535."""
    numbers = np.asarray(values, dtype=np.int64)
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < 2**16:
        raise ValueError(f"must be from 0 to 65535, not {numbers.min()} to {numbers.max()}")
    return _text(numbers.astype("<u2"))


def _text(array: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> str:
    return base64.b64encode(array.tobytes()).decode()


MOST_DRAWN = 20_000
"""Triangles of a mesh that is drawn alone, and most of its corners; a larger one is drawn coarser."""
GRIDS = (96, 72, 56, 40, 28, 20, 14, 10, 7)
"""Cells to the longest side in which a large mesh's places are made one, finest first, until what is left is small
enough."""
SEAMS = 64
"""Cells to the texture's side: corners at one place and in one of these cells are one."""
QUALITY = 86
SIDES = (2048, 1024, 512, 256, 128)
"""Most pixels of a texture's sides, which are powers of two, largest first, until it is small enough."""
LARGEST_PAINT, LONGEST_PAINT = 64 * 2**10, 512
"""Bytes and pixels of a texture that an interpretation carries: an object is seldom larger in a photo."""
SOURCES = "geometry", "sensing", "plogic/run/carried.py", "plogic/run/painted.py"
LIBRARIES = "numpy", "opencv-python-headless", "trimesh"
"""What makes a paint of a mesh."""
KEPT = 512
"""Paints that are kept from run to run; those used last."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """``vertices`` (V, 3) m, object frame; ``triangles`` (T, 3).

    ``uv`` (V, 2), (0, 0) at the texture's lower left, or None.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None

    def within(self, most: int) -> bool:
        """Whether it has at most so many triangles and corners."""
        return max(len(self.triangles), len(self.vertices)) <= most


def painted_mesh(kind: ObjectType) -> tuple["TexturedMesh | None", list[str]]:
    """The textured mesh, None where there is none or it cannot be read; and a sentence where it cannot."""
    from sensing.simulated.body import read_mesh

    if kind.mesh_file is None:
        return None, []
    try:
        mesh = read_mesh(kind.mesh_file, kind.mesh_scale)
    except SensingError as error:
        return None, [f"It is drawn without its texture: {error}."]
    return (mesh if mesh.uv is not None and np.isfinite(mesh.uv).all() else None), []


def coarser(mesh: Drawn, most: int = MOST_DRAWN) -> Drawn:
    """The mesh itself where it is small enough.

    Else with places of one grid cell made one, on the finest grid that does.
    """
    fewer = mesh
    for cells in GRIDS if not mesh.within(most) else ():
        fewer = _clustered(mesh, cells)
        if fewer.within(most):
            break
    return fewer


def _clustered(mesh: Drawn, cells: int) -> Drawn:
    place = cells_of(mesh.vertices, cells)
    corner = place if mesh.uv is None else alike(np.column_stack([place, np.floor(mesh.uv * SEAMS)]))
    triangles = corner[mesh.triangles[whole(place[mesh.triangles])]]
    _, first = np.unique(corner, return_index=True)
    used, index = np.unique(triangles, return_inverse=True)
    vertices = means(mesh.vertices, place)[place[first]][used]
    return Drawn(vertices, index.reshape(-1, 3), None if mesh.uv is None else means(mesh.uv, corner)[used])


def texture_picture(texture: NDArray[np.uint8], largest: int, longest: int) -> tuple[TextureRow, tuple[int, int]]:
    """JPEG of a BGR texture (H, W, 3), and its width and height, powers of two so that it can repeat.

    At most ``largest`` bytes and ``longest`` pixels a side.
    """
    import cv2

    for side in (side for side in SIDES if side <= longest):
        width, height = (min(side, 2 ** round(float(np.log2(size)))) for size in texture.shape[1::-1])
        small = texture
        if texture.shape[1::-1] != (width, height):
            small = np.asarray(cv2.resize(texture, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
        data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
        if data.size <= largest:
            break
    return {"media_type": "image/jpeg", "base64": base64.b64encode(data.tobytes()).decode()}, (width, height)


def paint_assets(types: Mapping[str, ObjectType]) -> AssetsRow:
    """``{"paints": {type: ...}}`` of the types whose mesh has a texture; nothing where none has."""
    rows = {name: row for name, kind in sorted(types.items()) if (row := _paint(kind)) is not None}
    return {"paints": rows} if rows else {}


@lru_cache(maxsize=64)
def _paint(kind: ObjectType) -> PaintRow | None:
    """Kept, for the frames of a stream show the same types, and on disk, for to read a mesh takes trimesh and SciPy."""
    if kind.mesh_file is None or (folder := cache_folder("paints")) is None:
        return _drawn(kind)
    try:
        content = content_of(kind.mesh_file, MAX_MESH_BYTES, SensingError)
    except SensingError:
        return None
    key = mesh_key(kind.mesh_file, content, kind.mesh_scale, read_by(LIBRARIES, SOURCES), pictures=True)

    def made() -> dict[str, NDArray[np.uint8]]:
        return {"row": np.frombuffer(json.dumps(_drawn(kind)).encode(), np.uint8)}

    row: PaintRow | None = json.loads(arrays_of(folder / key, ("row",), made, KEPT)["row"].tobytes())
    return row


def _drawn(kind: ObjectType) -> PaintRow | None:
    mesh = painted_mesh(kind)[0]
    if mesh is None or mesh.texture is None:
        return None
    if mesh.uv is not None and len(mesh.vertices) > SPLIT * len(mesh.triangles):
        return _coloured(mesh.vertices, mesh.triangles, mesh.uv, mesh.texture)
    drawn = coarser(Drawn(mesh.vertices, mesh.triangles, mesh.uv), MOST_TRIANGLES)
    return {
        "vertices": floats(drawn.vertices),
        "triangles": shorts(drawn.triangles),
        "uv": floats(np.zeros((0, 2)) if drawn.uv is None else drawn.uv),
        "picture": texture_picture(mesh.texture, LARGEST_PAINT, LONGEST_PAINT)[0],
    }


SPLIT = 2.5
"""Corners a triangle from which nearly each has its own piece of the texture, as one made of vertices' colours: joined
corners would have a mixture of pieces."""
MOST_COLOURED = 10_000
"""Triangles that are carried with vertices' colours: as many bytes as ``MOST_TRIANGLES`` with a texture."""
INWARD = 0.3
"""Share of the way to the middle of its piece at which a corner's colour is taken, off the piece's rim."""


def _coloured(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    uv: NDArray[np.float64],
    texture: NDArray[np.uint8],
) -> PaintRow:
    """The surface with a colour at each place; places of one grid cell are made one where it is too large."""
    corners = uv[triangles]
    inside = (corners + INWARD * (corners.mean(axis=1, keepdims=True) - corners)).reshape(-1, 2) % 1.0
    height, width = texture.shape[:2]
    x = np.minimum((inside[:, 0] * width).astype(int), width - 1)
    y = np.minimum(((1.0 - inside[:, 1]) * height).astype(int), height - 1)
    colour = texture[y, x, ::-1].astype(float)
    place = alike(np.round(vertices / np.ptp(vertices, axis=0).max() * 1e6))
    for cells in GRIDS:
        faces = place[triangles]
        kept = whole(faces)
        if len(kept) <= MOST_COLOURED:
            break
        place = cells_of(vertices, cells)
    used, index = np.unique(faces[kept], return_inverse=True)
    shades = np.zeros((int(place.max()) + 1, 3))
    shades[np.unique(faces)] = means(colour, np.unique(faces, return_inverse=True)[1].reshape(-1))
    return {
        "vertices": floats(means(vertices, place)[used]),
        "triangles": shorts(index.reshape(-1, 3)),
        "colours": _text(np.round(shades[used]).astype(np.uint8)),
    }
