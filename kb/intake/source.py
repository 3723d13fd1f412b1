"""A mesh file, as somebody made it, to triangles with their paint.

Vocabulary: ``Piece``, the triangles of one material, ``Piece(vertices, triangles, uv, picture)``; ``Source``, all
pieces of a file in its own unit, with ``notes`` on what could not be had.

``Picture``, an image file, ``Picture("png", data)``, whose bytes are decoded only where they must be.

The paint of all pieces becomes one OBJ, one MTL and one picture, whatever the source had: the textured mesh that is
rendered. One picture travels as it is. Several, and colours of vertices, become one atlas.
"""

import os.path
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.files.mesh_files import joined_meshes, meshes_of, reason, textures_in, triangles_of
from geometry.files.plain_files import IS_MISSING, fault_of
from kb.errors import IntakeError

MAGIC = {b"\x89PNG": "png", b"\xff\xd8\xff": "jpg", b"BM": "bmp", b"RIFF": "webp", b"II*\0": "tif", b"MM\0*": "tif"}
PLAIN = ("png", "jpg")
"""What is kept as it is; every other kind becomes a PNG."""


@dataclass(frozen=True)
class Picture:
    """An image file: its ``suffix``, png or jpg or whatever it is, and its bytes."""

    suffix: str
    data: bytes


def picture_from(data: bytes) -> Picture | None:
    """The picture of an image file's bytes; None where they do not begin like one, or OpenCV cannot read them."""
    suffix = next((kind for magic, kind in MAGIC.items() if data.startswith(magic)), None)
    found = pixels(data) if suffix is not None else None
    if suffix is None or found is None:
        return None
    return Picture(suffix, data) if suffix in PLAIN else png(found)


def pixels(data: bytes) -> NDArray[np.uint8] | None:
    """The pixels (H, W, 3) uint8, blue first; None where OpenCV cannot read the bytes."""
    try:
        found: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        return None
    return None if found is None else np.asarray(found, dtype=np.uint8)


def png(image: NDArray[np.uint8]) -> Picture:
    """A PNG of pixels (H, W, 3), blue first."""
    return Picture("png", cv2.imencode(".png", image)[1].tobytes())


def textures_of(path: Path) -> tuple[dict[str, Picture], list[str]]:
    """The pictures by name of material, '' meaning every material, and a note on each that is missing."""
    found, notes = textures_in(path)
    pictures = {}
    for texture in found:
        picture = picture_from(texture.data) if texture.data is not None else None
        if picture is None:
            notes.append(f"the {texture.label} {texture.fault or 'is missing or no picture'}: going on without")
        else:
            pictures[texture.material] = picture
    above = [texture.file for texture in found if texture.above and texture.file is not None]
    return pictures, list(dict.fromkeys([*notes, *copied(above, path.parent)]))


NAMED = 3
"""Files that a note names."""


def copied(files: Sequence[Path], folder: Path) -> list[str]:
    """A note on the files that were copied from outside of a folder, if there are any."""
    names = [str(os.path.normpath(file)) for file in dict.fromkeys(files)]
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return [f"copied from outside of {os.path.normpath(folder)}: {', '.join(names[:NAMED])}{more}"] if names else []


MAX_FILE_BYTES = 200_000_000
"""Largest mesh file; it is refused before it is read."""
MAX_TRIANGLES = 2_000_000
"""Most triangles of a mesh."""
FORMATS = ("obj", "ply", "stl", "glb", "gltf", "off", "dae")
"""Suffixes of the mesh files that are read; DAE where pycollada is installed."""
GREY = (190, 190, 190)
"""Red, green, blue of what has no colour of its own."""


@dataclass(frozen=True, eq=False)
class Piece:
    """``vertices`` (V, 3) in the file's unit, ``triangles`` (T, 3), and the paint.

    The paint is a ``picture`` with ``uv`` (V, 2), v upward, or ``colours`` (V, 3) red, green, blue of the vertices, or
    one ``colour``. ``name``: the link of a robot that it is of.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None
    picture: Picture | None = None
    colours: NDArray[np.uint8] | None = None
    colour: tuple[int, int, int] = GREY
    name: str = ""


@dataclass(frozen=True, eq=False)
class Source:
    """The ``pieces`` of one mesh, in one frame and unit; ``notes``: what was missing, a sentence each."""

    pieces: tuple[Piece, ...]
    notes: tuple[str, ...] = field(default=())

    @property
    def whole(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """All vertices (V, 3) and triangles (T, 3)."""
        return joined_meshes([(piece.vertices, piece.triangles) for piece in self.pieces])

    def moved(self, motion: NDArray[np.float64]) -> "Source":
        """The same by an affine ``motion`` (4, 4); a mirroring one turns the triangles over."""
        turned = slice(None, None, -1 if np.linalg.det(motion[:3, :3]) < 0 else 1)
        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # a size that is no number is told where it is held to the limits
            pieces = [
                replace(p, vertices=p.vertices @ motion[:3, :3].T + motion[:3, 3], triangles=p.triangles[:, turned])
                for p in self.pieces
            ]
        return Source(tuple(pieces), self.notes)


def read_source(path: Path) -> Source:
    """The triangles and paint of a mesh file.

    Raises:
        IntakeError: no such file, larger than the limits, of another format, no triangles, coordinates that are not
        finite.
    """
    _check_file(path)
    try:
        meshes = meshes_of(path)
    except Exception as error:  # - trimesh's readers raise whatever their parsers do
        raise IntakeError(f"{path}: is no mesh that can be read: {reason(path, error)}") from error
    number = sum(len(mesh.faces) for mesh, _ in meshes)
    if not number:
        raise IntakeError(f"{path}: holds no triangles")
    if number > MAX_TRIANGLES:
        raise IntakeError(
            f"{path}: has {number} triangles, more than the {MAX_TRIANGLES} that a mesh may have; simplify it first"
        )
    pictures, notes = textures_of(path)
    pieces = tuple(_piece(mesh, placed, pictures) for mesh, placed in meshes if len(mesh.faces))
    for piece in pieces:
        if not np.isfinite(piece.vertices).all():
            bad = int((~np.isfinite(piece.vertices).all(axis=1)).sum())
            raise IntakeError(f"{path}: {bad} vertices have coordinates that are not finite (NaN or infinite)")
    return Source(pieces, tuple(notes))


def _check_file(path: Path) -> None:
    fault = fault_of(path, MAX_FILE_BYTES)
    if fault is not None:
        raise IntakeError(f"{path}: there is no such mesh file" if fault == IS_MISSING else f"{path}: {fault}")
    if path.suffix.lower().lstrip(".") not in FORMATS:
        raise IntakeError(f"{path}: is no mesh file that can be read; these can: {', '.join(FORMATS)}")


def _piece(mesh: Any, placed: NDArray[np.float64], pictures: dict[str, Picture]) -> Piece:  # noqa: ANN401 - trimesh is untyped
    """One of trimesh's meshes; ``pictures`` by name of material, '' for all."""
    vertices, triangles = triangles_of(mesh, placed)
    used, index = np.unique(triangles, return_inverse=True)  # what no triangle uses is none of the surface
    triangles, number = index.reshape(-1, 3), len(vertices)
    material = getattr(mesh.visual, "material", None)
    picture = pictures.get(str(getattr(material, "name", "")), pictures.get(""))
    uv = getattr(mesh.visual, "uv", None)
    if picture is not None and uv is not None and len(uv) == number and np.isfinite(uv).all():
        return Piece(vertices[used], triangles, np.array(uv, dtype=np.float64)[used], picture, colour=_colour(material))
    seen = mesh.visual.vertex_colors if mesh.visual.kind == "vertex" else None
    colours = None if seen is None or len(seen) != number else np.array(seen, dtype=np.uint8)[used, :3]
    return Piece(vertices[used], triangles, colours=colours, colour=_colour(material))


def _colour(material: Any) -> tuple[int, int, int]:  # noqa: ANN401 - trimesh is untyped
    value = getattr(material, "main_color", None)
    if value is None:
        return GREY
    red, green, blue = (int(x) for x in np.asarray(value).ravel()[:3])
    return red, green, blue


Image = NDArray[np.uint8]
Painted = tuple[Piece, NDArray[np.float64]]


WIDEST = 8192
"""Most pixels of an atlas's side; pictures are halved until they fit."""
CELLS = 4096 * 4096
"""Pixels for the colours of vertices."""
MTL = "newmtl painted\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {}\n"


def painted_files(source: Source, scale: float) -> tuple[dict[str, bytes], str]:
    """``textured.obj`` in metres with its material and picture, and a word on the texture.

    No files where nothing is painted.

    ``scale`` is metres per unit of the source.
    """
    pictures = {piece.picture for piece in source.pieces}
    coloured = any(piece.colours is not None and len(np.unique(piece.colours, axis=0)) > 1 for piece in source.pieces)
    if pictures <= {None} and not coloured:
        return {}, "none"
    only = next(iter(pictures))
    if len(pictures) == 1 and only is not None:
        rows = [(p, p.uv) for p in source.pieces if p.uv is not None]
        return _files(rows, only, scale), f"one picture, {only.suffix}, as it is"
    rows, image = _atlas(source.pieces)
    number = len(pictures - {None})
    kinds = f"{number} picture{'s' if number > 1 else ''} and plain colours" if number else "the vertices' colours"
    return _files(rows, png(image), scale), f"{kinds}, in one atlas of {image.shape[1]}x{image.shape[0]} pixels"


def _files(rows: Sequence[Painted], picture: Picture, scale: float) -> dict[str, bytes]:
    name = f"texture.{picture.suffix}"
    return {
        "textured.obj": _obj_text(rows, scale).encode(),
        "textured.mtl": MTL.format(name).encode(),
        name: picture.data,
    }


def _obj_text(rows: Sequence[Painted], scale: float) -> str:
    """Each vertex with its own texture coordinate."""
    lines, first = ["mtllib textured.mtl", "usemtl painted"], 1
    for piece, uv in rows:
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in (piece.vertices * scale).tolist()]
        lines += [f"vt {u:.7g} {v:.7g}" for u, v in uv.tolist()]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (piece.triangles + first).tolist()]
        first += len(piece.vertices)
    return "\n".join(lines) + "\n"


def _atlas(pieces: Sequence[Piece]) -> tuple[list[Painted], Image]:
    """Every piece with its coordinates in one picture: tiles in columns, as high as they come."""
    budget = CELLS // max(1, sum(len(piece.triangles) for piece in pieces if piece.picture is None))
    cells = int(np.clip(np.sqrt(budget), 4, 16))
    pictures = list(dict.fromkeys(piece.picture for piece in pieces if piece.picture is not None))
    tiles: list[Image] = [tile for picture in pictures if (tile := pixels(picture.data)) is not None]
    laid: list[tuple[Piece, NDArray[np.float64], int]] = []
    for piece in pieces:
        if piece.picture is not None and piece.uv is not None:
            laid.append((*_within(piece, piece.uv), pictures.index(piece.picture)))
        else:
            own, uv, tile = _coloured(piece, cells)
            laid.append((own, uv, len(tiles)))
            tiles.append(tile)
    tiles = _fitting(tiles)
    width, height = sum(tile.shape[1] for tile in tiles), max(len(tile) for tile in tiles)
    image, left, rows = np.zeros((height, width, 3), dtype=np.uint8), np.cumsum([0] + [t.shape[1] for t in tiles]), []
    for tile, x in zip(tiles, left, strict=False):
        image[: len(tile), x : x + tile.shape[1]] = tile
    for piece, uv, number in laid:
        high, wide = tiles[number].shape[:2]
        places = np.stack([(left[number] + uv[:, 0] * wide) / width, 1 - (1 - uv[:, 1]) * high / height], axis=1)
        rows.append((piece, places))
    return rows, image


def _within(piece: Piece, uv: NDArray[np.float64]) -> tuple[Piece, NDArray[np.float64]]:
    """The piece with coordinates inside [0, 1], triangle by triangle.

    A triangle that repeats the picture gets its rim's pixels.
    """
    corners = uv[piece.triangles]
    shifted = np.clip(corners - np.floor(corners.mean(axis=1, keepdims=True)), 0.0, 1.0)
    count = 3 * len(piece.triangles)
    apart = replace(
        piece, vertices=piece.vertices[piece.triangles].reshape(-1, 3), triangles=np.arange(count).reshape(-1, 3)
    )
    return apart, shifted.reshape(-1, 2)


def _coloured(piece: Piece, cell: int) -> tuple[Piece, NDArray[np.float64], Image]:
    """A piece without a picture: a cell of the tile for each triangle in blended colours, or one plain tile."""
    if piece.colours is None:
        tile = np.tile(np.array(piece.colour[::-1], dtype=np.uint8), (8, 8, 1))
        return piece, np.full((len(piece.vertices), 2), 0.5), tile
    number = len(piece.triangles)
    across = int(np.ceil(np.sqrt(number)))
    steps = (np.arange(cell) - 1) / (cell - 3)
    u, v = steps[None, :, None], steps[:, None, None]
    a, b, c = np.moveaxis(piece.colours[piece.triangles].astype(np.float32)[..., ::-1], 1, 0)[:, :, None, None]
    blended = np.clip(a + (b - a) * u + (c - a) * v, 0, 255).astype(np.uint8)
    grid = np.zeros((across * across, cell, cell, 3), dtype=np.uint8)
    grid[:number] = blended
    tile = grid.reshape(across, across, cell, cell, 3).swapaxes(1, 2).reshape(across * cell, across * cell, 3)
    corner = np.stack([np.arange(number) % across, np.arange(number) // across], axis=1) * cell
    spots = corner[:, None] + np.array([[1.5, 1.5], [cell - 1.5, 1.5], [1.5, cell - 1.5]])
    uv = np.stack([spots[..., 0], across * cell - spots[..., 1]], axis=-1).reshape(-1, 2) / (across * cell)
    apart = replace(
        piece, vertices=piece.vertices[piece.triangles].reshape(-1, 3), triangles=np.arange(3 * number).reshape(-1, 3)
    )
    return apart, uv, tile


def _fitting(tiles: list[Image]) -> list[Image]:
    """The tiles, the largest halved until they stand side by side in the widest atlas."""
    import cv2

    while sum(tile.shape[1] for tile in tiles) > WIDEST or max(len(tile) for tile in tiles) > WIDEST:
        largest = max(range(len(tiles)), key=lambda i: max(tiles[i].shape[:2]))
        high, wide = (max(1, side // 2) for side in tiles[largest].shape[:2])
        if (high, wide) == tiles[largest].shape[:2]:
            break
        tiles[largest] = np.asarray(
            cv2.resize(tiles[largest], (wide, high), interpolation=cv2.INTER_AREA), dtype=np.uint8
        )
    return tiles
