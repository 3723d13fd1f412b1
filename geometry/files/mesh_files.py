"""The triangle meshes of a file as trimesh reads them, each at its place in the file's scene, and their textures.

A mesh file names its textures (OBJ through its MTL, PLY through its comment) or carries them (GLTF and GLB in their
JSON). The pictures are not decoded here: their bytes are handed on as they are.

Vocabulary: ``Texture``, the picture of one material, ``Texture("paint", "texture 'paint.png'", data)``.
"""

import base64
import binascii
import json
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.files.plain_files import fault_of, is_there

Placed = list[tuple[Any, Floats]]
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


def triangles_of(mesh: Any, file_from_mesh: Floats) -> tuple[Floats, Ints]:  # noqa: ANN401 - trimesh's
    """Vertices (V, 3) in the file's frame and triangles (T, 3), turned over where the placing mirrors."""
    vertices, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
    if not np.array_equal(file_from_mesh, np.eye(4)):
        vertices = vertices @ file_from_mesh[:3, :3].T + file_from_mesh[:3, 3]
        if np.linalg.det(file_from_mesh[:3, :3]) < 0:
            triangles = triangles[:, ::-1].copy()
    return vertices, triangles


def joined_meshes(parts: Sequence[tuple[Floats, Ints]]) -> tuple[Floats, Ints]:
    """The vertices (V, 3) and triangles (T, 3) of several meshes as those of one."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    triangles = [corners + start for (_, corners), start in zip(parts, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(triangles)


MAX_PICTURE_BYTES = 256 * 1024 * 1024
"""Largest texture; the same that an image may have."""
MAX_MTL_BYTES = 16_000_000
"""Largest material file."""
OPTIONS = {
    "-s": 3,
    "-o": 3,
    "-t": 3,
    "-mm": 2,
    "-bm": 1,
    "-blendu": 1,
    "-blendv": 1,
    "-clamp": 1,
    "-imfchan": 1,
    "-texres": 1,
    "-boost": 1,
}
"""Words after an option of a line of MTL, before the picture's name."""


@dataclass(frozen=True)
class Texture:
    """``material`` that it paints, '' meaning every one; ``label`` for people.

    ``data`` of the picture's file, None where it cannot be had.

    ``file``: where it lies, if it lies in a file of its own.
    """

    material: str
    label: str
    data: bytes | None
    file: Path | None = None


Found = tuple[list[Texture], list[str]]


def textures_in(path: Path) -> Found:
    """The textures, and a note on everything else that is missing."""
    kind = path.suffix.lower()
    if kind == ".obj":
        return _of_obj(path)
    if kind == ".ply":
        return [_of_name(path.parent, "", name) for name in _named_by_ply(path)], []
    return _of_gltf(path) if kind in (".glb", ".gltf") else ([], [])


def _of_obj(path: Path) -> Found:
    notes, found = [], []
    for name in _values(path, "mtllib"):
        library = path.parent / name
        fault = fault_of(library, MAX_MTL_BYTES)
        if fault is None:
            found += [_of_name(path.parent, material, file) for material, file in dict.fromkeys(_textures(library))]
        else:
            notes.append(f"the material file {name!r:.80} {fault}: going on without")
    return found, notes


def _textures(library: Path) -> Iterator[tuple[str, str]]:
    """(material, picture's file) of an MTL."""
    material = ""
    for line in library.read_text(encoding="utf-8", errors="replace").splitlines():
        key, _, rest = line.strip().partition(" ")
        if key == "newmtl":
            material = rest.strip()
        elif key.lower() == "map_kd" and rest.strip():
            yield material, _without_options(rest.split())


def _without_options(words: list[str]) -> str:
    while len(words) > 1 and words[0] in OPTIONS:
        words = words[min(1 + OPTIONS[words[0]], len(words) - 1) :]
    return " ".join(words).replace("\\", "/")


def _values(path: Path, key: str) -> list[str]:
    """The values of a key that stands at the beginning of lines; each once."""
    found: dict[str, None] = {}
    with path.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            if line.startswith(key) and len(line.split()) > 1:
                found[line.split(maxsplit=1)[1].strip()] = None
    return list(found)


def _named_by_ply(path: Path) -> list[str]:
    with path.open("rb") as file:
        start = file.read(20_000)
    head = start.split(b"end_header")[0].decode("utf-8", errors="replace")
    return [
        line.split(maxsplit=2)[2].strip()
        for line in head.splitlines()
        if line.startswith("comment TextureFile ") and len(line.split()) > 2
    ]


def _of_name(folder: Path, material: str, name: str) -> Texture:
    return Texture(material, f"texture {name!r:.80}", _file_of(folder / name) or None, folder / name)


def _of_gltf(path: Path) -> Found:
    data = path.read_bytes()
    try:
        tree, binary = _chunks(data) if data[:4] == b"glTF" else (json.loads(data), b"")
        rows = [(str(row.get("name", "")), row) for row in tree.get("materials", [])]
        found = {name: _bytes_of(tree, binary, row, path.parent) for name, row in rows}
    except (
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        RecursionError,
        struct.error,
        OSError,
        binascii.Error,
    ) as error:
        return [], [f"the textures cannot be read ({type(error).__name__}): going on without"]
    return [
        Texture(name, f"texture of material {name!r:.80}", content or None)
        for name, content in found.items()
        if content is not None
    ], []


def _chunks(data: bytes) -> tuple[Any, bytes]:
    """The JSON and the binary chunk of a GLB."""
    size = struct.unpack_from("<I", data, 12)[0]
    start = 20 + size
    return json.loads(data[20:start]), data[start + 8 :]


def _bytes_of(tree: Any, binary: bytes, material: Any, folder: Path) -> bytes | None:  # noqa: ANN401 - JSON
    """The bytes of a material's picture; None for one without."""
    entry = material.get("pbrMetallicRoughness", {}).get("baseColorTexture")
    if entry is None:
        return None
    image = tree["images"][tree["textures"][entry["index"]]["source"]]
    if "uri" in image:
        uri = image["uri"]
        return base64.b64decode(uri.partition(",")[2]) if uri.startswith("data:") else _file_of(folder / unquote(uri))
    view = tree["bufferViews"][image["bufferView"]]
    start = view.get("byteOffset", 0)
    return binary[start : start + view["byteLength"]]


def _file_of(path: Path) -> bytes:
    """A picture's bytes; none where it cannot be had."""
    try:
        return path.read_bytes() if fault_of(path, MAX_PICTURE_BYTES) is None else b""
    except OSError:
        return b""
