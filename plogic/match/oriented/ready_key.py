"""What decides the index over types, as one key: the types themselves as they enter it, in their order, our source, and the libraries.

Neither dv nor the rates enter what is kept.

* ``key_of(types)``: 64 hex digits
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from plogic.base.remembered import ROOT, source_digest, sources_in

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kb.clouds.cloud import ObjectType

SOURCES = "geometry", "kb", "plogic/base", "plogic/match", "plogic/measures"
"""What makes an index, methods of the types and their surfaces too; whole folders, for no import leads to the class of
what is handed in."""
LIBRARIES = ("numpy", "embreex")
"""They compute, and shoot the rays."""


def key_of(types: Sequence[ObjectType]) -> str:
    """SHA-256 over all of some types that an index may say, the source that makes it, and the libraries' versions."""
    total = hashlib.sha256(_made_by())
    for kind in types:
        total.update(_content(kind))
    return total.hexdigest()


@cache
def _made_by() -> bytes:
    return repr([version(name) for name in LIBRARIES]).encode() + source_digest(ROOT, sources_in(ROOT, SOURCES))


def _content(kind: ObjectType) -> bytes:
    """SHA-256 over a type: its features, their lobes, its surface and symmetries."""
    features, table, surface = kind.features, kind.lobes, kind.surface
    named = [(feature.name, feature.type, feature.parts, len(feature.arms)) for feature in features]
    total = hashlib.sha256(repr((kind.name, kind.opaque, surface is None, named, table.types, table.features)).encode())
    arrays = [
        np.array([feature.at for feature in features]), np.array([feature.rotation for feature in features]),
        np.concatenate([np.zeros((0, 3)), *(feature.arms for feature in features)]), kind.symmetries,
        table.feature, table.at, table.axis, table.cos_half, table.r_min, table.r_max, table.size,
    ]  # fmt: skip
    for array in arrays if surface is None else [*arrays, surface.vertices, surface.triangles]:
        total.update(f"{array.dtype.str}{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return total.digest()
