"""All hand-modelled types whose data have angles, made ready for the search of all at once.

Kept on disk between runs, and mapped from there.

* ``OrientedIndex``: one such type
* ``ready(types, dv, folder)``: the indices of the types, and the index over them
* ``key_of(types)``: what decides the index over types, as 64 hex digits: the types themselves as they enter it, in
  their order, our source, and the libraries. Neither dv nor the rates enter what is kept
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.base.remembered import ROOT, arrays_of, source_digest, sources_in
from plogic.match.hand.hand_models import TypeIndex, type_index
from plogic.match.hand.view_cells import ViewCells, remade
from plogic.match.oriented.oriented_match import settle
from plogic.match.oriented.pair_index import PairIndex, Sights, looks_of, pair_index

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from geometry.arrays import Floats, Mask
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.gamma.data import Data

    Arrays = Mapping[str, NDArray[Any]]


class OrientedIndex(TypeIndex):
    """A type that is matched by places and angles."""

    def settle(
        self,
        pose: Floats | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: Mask | None = None,
        hidden: Mask | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose, matched and refined on places and angles (``plogic.match.oriented.oriented_match``)."""
        return settle(self, pose, data, kb, free, hidden, rounds)


def oriented_index(object_type: ObjectType, dv: Mapping[str, float], cells: ViewCells | None = None) -> OrientedIndex:
    """Build the index of one type. ``cells``, where they are known."""
    return type_index(object_type, dv, cells, OrientedIndex)


SOURCES = "geometry", "kb", "plogic/base", "plogic/facts", "plogic/match", "plogic/measures"
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


MANY = 20
"""Fewer types are made ready within a second, about, and not kept."""
_CELLS, _SIGHTS, _PAIRS = (
    ("xy", "visible", "arms"),
    ("feature", "looks", "xy", "angle", "diameter"),
    ("key", "entry", "turned"),
)
_NAMES = [*(f"cells_{name}" for name in _CELLS), *(f"sights_{name}" for name in _SIGHTS), *_PAIRS]


def ready(types: Sequence[ObjectType], dv: Mapping[str, float], folder: Path | None = None) -> PairIndex:
    """The index over some types; ``folder``: where indices are kept."""
    if folder is None or len(types) < MANY:
        return pair_index([oriented_index(kind, dv) for kind in types])
    arrays = arrays_of(
        folder / key_of(types), _NAMES, lambda: _arrays(pair_index([oriented_index(kind, dv) for kind in types]))
    )
    ends = np.cumsum([0, *(len(kind.features) for kind in types)])
    indices = [
        oriented_index(kind, dv, remade(kind, *_of_type(arrays, low, high)))
        for kind, low, high in zip(types, ends[:-1], ends[1:], strict=True)
    ]
    sights = Sights(*(arrays[f"sights_{name}"] for name in _SIGHTS))
    return PairIndex(tuple(indices), looks_of(types), sights, *(arrays[name] for name in _PAIRS))


def _arrays(index: PairIndex) -> Arrays:
    arms = max((cells.arms.shape[2] for cells in index.cells), default=0)
    wide = [
        np.pad(cells.arms, ((0, 0), (0, 0), (0, arms - cells.arms.shape[2])), constant_values=np.nan)
        for cells in index.cells
    ]
    cells = {
        "cells_xy": np.concatenate([cells.xy for cells in index.cells], axis=1),
        "cells_visible": np.concatenate([cells.visible for cells in index.cells], axis=1),
        "cells_arms": np.concatenate(wide, axis=1),
    }
    return (
        cells
        | {f"sights_{name}": getattr(index.sights, name) for name in _SIGHTS}
        | {name: getattr(index, name) for name in _PAIRS}
    )


def _of_type(arrays: Arrays, low: int, high: int) -> list[NDArray[Any]]:
    return [arrays[f"cells_{name}"][:, low:high] for name in _CELLS]
