"""The files that a mesh file names: materials, pictures and buffers. Nobody but this module finds and reads them.

A name is relative to the mesh file. Materials (OBJ) and buffers (glTF) lie in its folder or below; pictures also in up
to two folders above and below those, as in ``../textures/a.png``. Links are followed, and must not lead out of there.
Neither the root of the file system nor the user's home, nor what is above it, counts as a folder above.

Vocabulary: ``Side("picture", "a.png", Path("a.png"), None, "paint")``, what one name leads to.

* ``side_files(path, content)``: all that a mesh file names, and what its materials name, each with what forbids it
* ``side.read()``: its bytes
* ``homes(path, 2)``, ``inside(place, folders)``: the folders that a file may name files of
"""

import json
import os.path
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, Literal
from urllib.parse import unquote

from geometry.files.plain_files import IS_MISSING, fault_of

Kind = Literal["material", "buffer", "picture"]
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".webp", ".tif", ".tiff", ".tga", ".gif")
"""What the name of a picture in a folder above ends with."""
ABOVE = 2
"""Folders above the mesh file's whose pictures it may name."""
LIMITS: dict[Kind, int] = {"material": 16_000_000, "buffer": 200_000_000, "picture": 256 * 1024 * 1024}
"""Largest file of each kind, bytes; a picture's is the same that an image may have."""
MOST_BYTES = 1 << 30
"""Most bytes of all files that one mesh file names."""
MOST_FILES = 1000
"""Most names that are looked at."""
NO_RELATIVE = "is no relative name"
"""The fault of an absolute path, and of an address such as ``file://`` and ``https://``."""
LEADS_OUT = "leads out of the mesh file's folder"
_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|[/~]")
_OPTIONS = {
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
class Side:
    """What the ``name`` in a mesh file leads to: ``place``, and its ``fault``, to be said after its name, or None.

    ``material``: of a picture, what it paints; '' means everything. ``above``: it lies in a folder above.
    """

    kind: Kind
    name: str
    place: Path
    fault: str | None
    material: str = ""
    above: bool = False

    def read(self) -> bytes:
        """The bytes. Raises FileNotFoundError where it has a fault, or is gone."""
        if self.fault is not None:
            raise FileNotFoundError(f"{self.name!r:.100} {self.fault}")
        try:
            with self.place.open("rb") as file:
                return file.read(LIMITS[self.kind])
        except OSError as error:
            raise FileNotFoundError(f"{self.name!r:.100} cannot be read: {error.strerror}") from None


def side_files(path: Path, content: bytes) -> list[Side]:
    """What the mesh file at ``path``, of this content, names, in its order; embedded data is no file.

    Raises nothing: a glTF that cannot be read names nothing.
    """
    found, total = [], 0
    for side in islice(_named(path, content), MOST_FILES):
        total += _size(side.place) if side.fault is None else 0
        too_much = f"is, with what is named before it, larger than the {MOST_BYTES} bytes that are read"
        found.append(replace(side, fault=too_much) if total > MOST_BYTES and side.fault is None else side)
    return found


def _size(place: Path) -> int:
    try:
        return place.stat().st_size
    except OSError:  # gone meanwhile
        return 0


def _named(path: Path, content: bytes) -> Iterator[Side]:
    suffix = path.suffix.lower()
    if suffix == ".obj":
        for name in _values(content, rb"mtllib"):
            library = _found(path, "material", name)
            yield library
            for material, picture in dict.fromkeys(pictures_of(library)):
                yield replace(_found(path, "picture", picture), material=material)
    elif suffix == ".ply":
        for name in _values(content[:20_000].split(b"end_header")[0], rb"comment TextureFile"):
            yield _found(path, "picture", name)
    elif suffix in (".gltf", ".glb"):
        tree = gltf_parts(content)[0]
        for kind, key in (("buffer", "buffers"), ("picture", "images")):
            for uri in _uris(tree, key):
                yield replace(_found(path, "buffer" if kind == "buffer" else "picture", unquote(uri)), name=uri)


def _found(path: Path, kind: Kind, name: str) -> Side:
    """What a name leads to; a picture's backslashes are those of another system."""
    plain = name.strip().replace("\\", "/") if kind == "picture" else name.strip()
    place = path.parent / plain
    if _ADDRESS.match(plain) or "\0" in plain:
        return Side(kind, name, place, NO_RELATIVE)
    if inside(place, homes(path)):
        return Side(kind, name, place, fault_of(place, LIMITS[kind]))
    may = kind == "picture" and plain.lower().endswith(PICTURES) and inside(place, homes(path, ABOVE))
    return Side(kind, name, place, fault_of(place, LIMITS[kind]) if may else LEADS_OUT, above=True)


def homes(path: Path, above: int = 0) -> set[Path]:
    """The folder that a file is in, and that of the file which it is a link to, or so many folders above them."""
    return {
        _upward(Path(os.path.realpath(place)), above) for place in (path.parent, Path(os.path.realpath(path)).parent)
    }


def _upward(folder: Path, above: int) -> Path:
    """The real folder so many above, but neither the root, nor the user's home, nor what that lies in."""
    home = Path(os.path.realpath(os.path.expanduser("~")))  # noqa: PTH111 - where nobody knows the home, pathlib raises
    for _ in range(above):
        if home.is_relative_to(folder.parent):
            break
        folder = folder.parent
    return folder


def inside(place: Path, folders: set[Path]) -> bool:
    """Whether a place, links followed, is below one of the real folders; not where no file can have such a name."""
    try:
        real = Path(os.path.realpath(place))
    except ValueError:
        return False
    return any(real.is_relative_to(folder) for folder in folders)


def _values(content: bytes, key: bytes) -> list[str]:
    """The values of a key that stands at the beginning of lines; each once."""
    found = re.finditer(rb"^[ \t]*" + key + rb"[ \t]+([^\r\n]+)", content, re.MULTILINE)
    names = (match[1][:5000].decode("utf-8", errors="replace").strip() for match in found)
    return list(dict.fromkeys(islice(names, MOST_FILES)))


def pictures_of(library: Side) -> Iterator[tuple[str, str]]:
    """(material, picture's name) of an MTL; nothing of one that cannot be read."""
    material = ""
    try:
        lines = library.read().decode("utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return
    for line in lines:
        key, _, rest = line.strip().partition(" ")
        if key == "newmtl":
            material = rest.strip()
        elif key.lower() == "map_kd" and rest.strip():
            yield material, _without_options(rest.split())


def _without_options(words: list[str]) -> str:
    while len(words) > 1 and words[0] in _OPTIONS:
        words = words[min(1 + _OPTIONS[words[0]], len(words) - 1) :]
    return " ".join(words)


def gltf_parts(content: bytes) -> tuple[Any, bytes]:
    """The JSON and the binary chunk of a glTF or GLB; None and nothing where it has none."""
    try:
        if content[:4] != b"glTF":
            return json.loads(content), b""
        start = 20 + struct.unpack_from("<I", content, 12)[0]
        return json.loads(content[20:start]), content[start + 8 :]
    except (ValueError, RecursionError, struct.error):
        return None, b""


def _uris(tree: Any, key: str) -> Iterator[str]:  # noqa: ANN401 - JSON
    """The names of files under ``buffers`` or ``images``, each once."""
    rows = tree.get(key) if isinstance(tree, dict) else None
    uris = [row.get("uri") for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []
    yield from dict.fromkeys(uri for uri in uris if isinstance(uri, str) and not is_data(uri))


def is_data(uri: str) -> bool:
    """Whether it carries its content itself."""
    return uri.startswith("data:") or "base64," in uri


def is_lost(side: Side) -> bool:
    """Whether the name leads nowhere that could be looked at: the mesh is read without it."""
    return side.fault in (IS_MISSING, NO_RELATIVE)
