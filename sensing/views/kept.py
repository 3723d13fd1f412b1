"""Views of meshes that were seen before: to draw and to measure four hundred takes seconds."""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from geometry.files.remembered import ROOT, arrays_of, source_digest, sources
from sensing.pixels.drawn import Paint
from sensing.views.views import Views, views_of

KEPT = 512
"""Types whose views are kept; those used last."""
LIBRARIES = "embreex", "numpy", "opencv-python-headless"


def kept_views(paint: Paint, number: int, folder: Path | None) -> Views:
    """``views_of`` a painted mesh; ``folder``: where views are kept, None for nowhere."""
    if folder is None:
        return views_of(paint, number)
    mesh = paint.mesh
    said = hashlib.sha256(_seen_by() + repr((number, mesh.colour)).encode())
    for array in (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture):
        if array is not None:
            said.update(repr((array.shape, array.dtype.str)).encode() + np.ascontiguousarray(array).tobytes())
    return Views(**arrays_of(folder / said.hexdigest(), Views._fields, lambda: views_of(paint, number)._asdict(), KEPT))


@cache
def _seen_by() -> bytes:
    here = str(Path(__file__).with_name("views.py").relative_to(ROOT))
    return repr([version(name) for name in LIBRARIES]).encode() + source_digest(ROOT, sources(ROOT, here))
