"""A mesh file, as somebody made it, to triangles with their paint.

Vocabulary: ``Piece``, the triangles of one material, ``Piece(vertices, triangles, uv, picture)``; ``Source``, all
pieces of a file in its own unit, with ``notes`` on what could not be had.

``Picture``, an image file, ``Picture("png", data)``, whose bytes are decoded only where they must be.
"""

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
            notes.append(f"the {texture.label} is missing or no picture: going on without")
        else:
            pictures[texture.material] = picture
    return pictures, list(dict.fromkeys(notes))


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
    """``vertices`` (V, 3) in the file's unit, ``triangles`` (T, 3), and the paint: a ``picture`` with ``uv`` (V, 2), v upward, or
    ``colours`` (V, 3) red, green, blue of the vertices, or one ``colour``.
    """  # noqa: D205 - one object, one sentence

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None
    picture: Picture | None = None
    colours: NDArray[np.uint8] | None = None
    colour: tuple[int, int, int] = GREY


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
    colours = None if seen is None else np.array(seen, dtype=np.uint8)[used, :3]
    return Piece(vertices[used], triangles, colours=colours, colour=_colour(material))


def _colour(material: Any) -> tuple[int, int, int]:  # noqa: ANN401 - trimesh is untyped
    value = getattr(material, "main_color", None)
    if value is None:
        return GREY
    red, green, blue = (int(x) for x in np.asarray(value).ravel()[:3])
    return red, green, blue
