"""Surfaces of meshes that were read before: to read one again takes trimesh and SciPy, longer than all else of a KB.

A surface is found again by the mesh file's bytes and those of the materials and buffers that it names, its scale, the
code that reads it, and the libraries' versions.

* ``kept_surface(path, content, scale, folder)``
* ``mesh_key(path, content, scale, by)``: the name under which what was made of a mesh is kept
"""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from geometry.files.remembered import ROOT, arrays_of, source_digest, sources_in
from geometry.files.side_files import Side, side_files
from kb.surfaces.surface import Surface, surface_from_mesh

SOURCES = "geometry", "kb/surfaces"
"""What reads a mesh."""
LIBRARIES = "numpy", "scipy", "trimesh"
KEPT = 512
"""Surfaces that are kept; those used last."""


def kept_surface(path: Path, content: bytes, scale: float, folder: Path | None) -> Surface:
    """``surface_from_mesh`` of a file with this content; ``folder``: where surfaces are kept, None for nowhere.

    Raises SurfaceError, as it does.
    """
    if folder is None:
        return surface_from_mesh(path, scale)
    key = mesh_key(path, content, scale, read_by(LIBRARIES, SOURCES))

    def read() -> dict[str, np.ndarray]:
        surface = surface_from_mesh(path, scale)
        return {"vertices": surface.vertices, "triangles": surface.triangles}

    arrays = arrays_of(folder / key, ("vertices", "triangles"), read, KEPT)
    return Surface(arrays["vertices"], arrays["triangles"])


def mesh_key(path: Path, content: bytes, scale: float, by: bytes, *, pictures: bool = False) -> str:
    """64 hex digits of a mesh file with this content, the files that it names, its scale, and ``by``, who reads it."""
    sides = [_digest(side) for side in side_files(path, content) if pictures or side.kind != "picture"]
    said = [by, f"{path.suffix.lower()} {scale!r}".encode(), *sides, content]
    return hashlib.sha256(b"".join(hashlib.sha256(one).digest() for one in said)).hexdigest()


def _digest(side: Side) -> bytes:
    """What a file beside the mesh is: a material may decide in what order facets come."""
    try:
        return side.name.encode() + b"\n" + hashlib.sha256(side.read()).digest()
    except FileNotFoundError:
        return side.name.encode()


@cache
def read_by(libraries: tuple[str, ...], places: tuple[str, ...]) -> bytes:
    """The versions of libraries, and what our own code in some places of it is."""
    return repr([version(name) for name in libraries]).encode() + source_digest(ROOT, sources_in(ROOT, places))
