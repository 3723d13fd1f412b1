"""Surfaces of meshes that were read before: to read one again takes trimesh and SciPy, longer than all else of a KB.

A surface is found again by the mesh file's bytes, its scale, the code that reads it, and the libraries' versions.
"""

import hashlib
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from geometry.files.mesh_files import MAX_MTL_BYTES
from geometry.files.plain_files import fault_of
from geometry.files.remembered import ROOT, arrays_of, source_digest, sources_in
from kb.surfaces.surface import Surface, surface_from_mesh

SOURCES = "geometry", "kb/surfaces"
"""What reads a mesh."""
LIBRARIES = "numpy", "scipy", "trimesh"
WHOLE = frozenset({".obj", ".ply", ".stl", ".off", ".glb"})
"""Formats of which no other file says where a facet is."""
KEPT = 512
"""Surfaces that are kept; those used last."""


def kept_surface(path: Path, content: bytes, scale: float, folder: Path | None) -> Surface:
    """``surface_from_mesh`` of a file with this content; ``folder``: where surfaces are kept, None for nowhere.

    Raises SurfaceError, as it does.
    """
    kind = path.suffix.lower()
    if folder is None or kind not in WHOLE:
        return surface_from_mesh(path, scale)
    said = _read_by() + f"{kind} {scale!r} {len(materials := _materials(path, content))}\n".encode() + materials
    key = hashlib.sha256(hashlib.sha256(said).digest() + content).hexdigest()

    def read() -> dict[str, np.ndarray]:
        surface = surface_from_mesh(path, scale)
        return {"vertices": surface.vertices, "triangles": surface.triangles}

    arrays = arrays_of(folder / key, ("vertices", "triangles"), read, KEPT)
    return Surface(arrays["vertices"], arrays["triangles"])


def _materials(path: Path, content: bytes) -> bytes:
    """The file of materials that an OBJ names: they may decide in what order its facets come."""
    named = re.search(rb"^mtllib[ \t]+(.*)$", content, re.MULTILINE) if path.suffix.lower() == ".obj" else None
    beside = path.parent / named[1].strip().decode(errors="replace") if named else path
    return beside.read_bytes() if beside != path and fault_of(beside, MAX_MTL_BYTES) is None else b""


@cache
def _read_by() -> bytes:
    return repr([version(name) for name in LIBRARIES]).encode() + source_digest(ROOT, sources_in(ROOT, SOURCES))
