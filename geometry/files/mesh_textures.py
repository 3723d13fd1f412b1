"""The textures that a mesh file names or carries: OBJ through its MTL, PLY through its comment, GLTF and GLB in their JSON.

The pictures are not decoded here: their bytes are handed on as they are.

Vocabulary: ``Texture``, the picture of one material, ``Texture("paint", "texture 'paint.png'", data)``.
"""

import base64
import binascii
import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from geometry.files.plain_files import fault_of

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
