"""The triangle meshes of a file as trimesh reads them, each at its place in the file's scene, and their textures.

A mesh file names its textures (OBJ through its MTL, PLY through its comment) or carries them (GLTF and GLB in their
JSON). The pictures are not decoded here: their bytes are handed on as they are.

trimesh opens no file: it is given the mesh file's bytes, and of what it asks for beside them the materials and buffers
that ``geometry.files.side_files`` found.

Vocabulary: ``Texture``, the picture of one material, ``Texture("paint", "texture 'paint.png'", data)``.
"""

import base64
import binascii
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.files.plain_files import IS_MISSING
from geometry.files.side_files import Side, gltf_parts, is_data, side_files
from geometry.files.xml_files import root_of

logging.getLogger("trimesh").addHandler(logging.NullHandler())  # without one, tracebacks are printed
Placed = list[tuple[Any, Floats]]
COMPRESSED = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
"""Extensions of glTF: where a file needs one, its surface is not there without it."""
PLACES = {"POSITION", "TEXCOORD_0"}
"""What trimesh reads as it is stored, also where it is to be divided by the largest whole number."""
_NO_GLTF = LookupError, OSError, RecursionError, TypeError, AttributeError, AssertionError
"""What its reader raises where the JSON is not what it expects."""


def meshes_of(path: Path) -> Placed:
    """Every ``trimesh.Trimesh`` of the file with ``file_from_mesh`` (4, 4), which may scale and mirror.

    Nothing is merged or copied.

    Raises whatever trimesh's readers raise, which is anything; ``reason`` puts it into words.
    """
    import trimesh

    scene = scene_of(path)
    order = {name: index for index, name in enumerate(scene.geometry)}  # the graph's own order changes from run to run
    nodes = sorted(
        (order[name], str(node), name, placed)
        for node in scene.graph.nodes_geometry
        for placed, name in [scene.graph[node]]
    )
    meshes = [(scene.geometry[name], np.asarray(placed, dtype=np.float64)) for _, _, name, placed in nodes]
    found = [(mesh, placed) for mesh, placed in meshes if isinstance(mesh, trimesh.Trimesh)]
    for mesh, _ in found:
        if len(mesh.faces) and not 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices):
            raise ValueError("a triangle has a corner that is none of its vertices")
    return found


def scene_of(path: Path) -> Any:  # noqa: ANN401 - trimesh's
    """The ``trimesh.Scene`` of a mesh file, its meshes as they stand there. Raises whatever trimesh's readers raise."""
    import trimesh

    content, kind = path.read_bytes(), path.suffix.lower().lstrip(".")
    beside: Any = _Beside(path.name, {side.name: side for side in side_files(path, content) if side.kind != "picture"})
    if kind == "dae":  # its reader would follow entities
        content = ET.tostring(root_of(content.decode("utf-8-sig"), "mesh"))
    elif kind in ("gltf", "glb"):
        _check_numbers(gltf_parts(content)[0])
    return trimesh.load_scene(BytesIO(content), file_type=kind, process=False, resolver=beside)


def _check_numbers(tree: Any) -> None:  # noqa: ANN401 - JSON
    """Refuse a glTF whose places trimesh would misread: packed ones. Raises ValueError, or whatever fits no glTF."""
    for name in COMPRESSED:
        if name in tree.get("extensionsRequired", ()):
            raise ValueError(f"its surface is compressed ({name}): export it without")
    for mesh in tree["meshes"] if isinstance(tree.get("meshes"), list) else ():  # glTF 1 has an object there
        for primitive in mesh["primitives"]:
            for name in PLACES & primitive["attributes"].keys():
                if tree["accessors"][primitive["attributes"][name]].get("normalized"):
                    raise ValueError(f"its numbers of {name} are packed (KHR_mesh_quantization): export it without")


@dataclass(frozen=True)
class _Beside:
    """What a mesh file names beside it, for trimesh, which calls this its resolver. Of its pictures nothing is told."""

    file_name: str
    sides: Mapping[str, Side]

    def get(self, name: str) -> bytes:
        if name not in self.sides:
            raise FileNotFoundError(name)
        return self.sides[name].read()

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)


def reason(path: Path, error: Exception) -> str:
    """Why trimesh could not read a mesh file, in one line of at most 200 characters.

    Raises:
        MemoryError: the error itself, which is none of the file.
    """
    if isinstance(error, MemoryError):
        raise error
    if isinstance(error, ModuleNotFoundError) and error.name == "charset_normalizer":
        return "it holds bytes that are no text in UTF-8"
    if isinstance(error, ModuleNotFoundError):
        return f"reading it needs the package {error.name}, or convert the mesh to OBJ or GLB"
    if isinstance(error, FileNotFoundError) and error.errno is None:
        return f"its buffer {error}"
    if path.suffix.lower() in (".gltf", ".glb") and isinstance(error, _NO_GLTF):
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


@dataclass(frozen=True)
class Texture:
    """``material`` that it paints, '' meaning every one; ``label`` for people.

    ``data`` of the picture's file, None where it cannot be had; ``fault``: why, where more is known than that.

    ``file``: where it lies, if it lies in a file of its own; ``above``: in a folder above the mesh file's.
    """

    material: str
    label: str
    data: bytes | None
    file: Path | None = None
    fault: str | None = None
    above: bool = False


Found = tuple[list[Texture], list[str]]


def textures_in(path: Path) -> Found:
    """The textures, and a note on everything else that is missing."""
    content, kind = path.read_bytes(), path.suffix.lower()
    sides = side_files(path, content)
    notes = [
        f"the material file {side.name!r:.80} {side.fault}: going on without"
        for side in sides
        if side.kind == "material" and side.fault is not None
    ]
    if kind in (".glb", ".gltf"):
        return _of_gltf(content, {side.name: side for side in sides})
    return [_of_side(side) for side in sides if side.kind == "picture"], notes


def _of_side(side: Side) -> Texture:
    fault = None if side.fault == IS_MISSING else side.fault
    label = f"texture {side.name!r:.80}"
    return Texture(side.material, label, _bytes_of(side), None if fault else side.place, fault, side.above)


def _bytes_of(side: Side) -> bytes | None:
    try:
        return side.read() or None
    except FileNotFoundError:
        return None


def _of_gltf(content: bytes, sides: Mapping[str, Side]) -> Found:
    tree, binary = gltf_parts(content)
    try:
        rows = [(f"texture of material {str(row.get('name', ''))!r:.80}", row) for row in tree.get("materials", [])]
        found = [_of_material(label, row, tree, binary, sides) for label, row in rows]
    except (ValueError, LookupError, TypeError, AttributeError, OSError, binascii.Error) as error:
        return [], [f"the textures cannot be read ({type(error).__name__}): going on without"]
    return [texture for texture in found if texture is not None], []


def _of_material(label: str, row: Any, tree: Any, binary: bytes, sides: Mapping[str, Side]) -> Texture | None:  # noqa: ANN401 - JSON
    """The picture of a material; None for one without."""
    name, entry = str(row.get("name", "")), row.get("pbrMetallicRoughness", {}).get("baseColorTexture")
    if entry is None:
        return None
    image = tree["images"][tree["textures"][entry["index"]]["source"]]
    if "uri" not in image:
        view = tree["bufferViews"][image["bufferView"]]
        start, buffer = view.get("byteOffset", 0), tree["buffers"][view["buffer"]]
        whole = _content_of(buffer["uri"], sides) if "uri" in buffer else binary
        return Texture(name, label, whole[start : start + view["byteLength"]] or None)
    if is_data(image["uri"]):
        return Texture(name, label, _content_of(image["uri"], sides) or None)
    found = _of_side(sides[image["uri"]])
    return Texture(name, label, found.data, None, found.fault, found.above)


def _content_of(uri: str, sides: Mapping[str, Side]) -> bytes:
    """The bytes of a buffer or picture that is named, or that is carried in its name."""
    return base64.b64decode(uri.partition("base64,")[2]) if is_data(uri) else sides[uri].read()
