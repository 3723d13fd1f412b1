"""The types of ``plogic bench scale``: one set of bodies, told apart by more or by fewer appearance types.

Made ready in sets, each in the next.

* ``Bodies``: types and their view cells, which do not depend on what the features look like
* ``Ready``: Σ of the first of them, and the index over them
"""

from __future__ import annotations

import tempfile
import tracemalloc
from dataclasses import dataclass, fields
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.types import EASY, HALF_ANGLE, knowledge_base, made, random_types, type_names
from plogic.match.hand.view_cells import view_cells
from plogic.match.oriented.oriented_models import oriented_index
from plogic.match.oriented.pair_index import PairIndex, Sights, pair_index
from plogic.measures.distinctiveness import distinctiveness, instance_counts

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.match.hand.hand_models import TypeIndex
    from plogic.match.hand.view_cells import ViewCells

FEATURES = 100
"""Of a type."""
LOOKS = 3000
"""Appearance types of the bodies as they are drawn; fewer are these modulo their number, which has to divide it."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """``seconds``: of the processor, a type, for its view cells."""

    types: Sequence[ObjectType]
    cells: Sequence[ViewCells]
    seconds: float

    def alike(self, looks: int) -> list[ObjectType]:
        """The same bodies with so many appearance types."""
        return list(self.types) if looks == LOOKS else [_relabelled(kind, looks) for kind in self.types]


@dataclass(frozen=True, eq=False)
class Ready:
    """What a ``Perceiver`` holds.

    ``seconds`` of the processor that it took to make the index of view cells that were there.
    """

    kb: KnowledgeBase
    dv: Mapping[str, float]
    indices: Mapping[str, TypeIndex]
    shared: PairIndex
    seconds: float


def bodies(count: int, seed: int) -> Bodies:
    """So many random types; fewer of the same seed are the first of more."""
    types = random_types(count, FEATURES, LOOKS, np.random.default_rng([seed, LOOKS]), EASY).types
    start = process_time()
    cells = [view_cells(kind) for kind in types]
    return Bodies(types, cells, (process_time() - start) / count)


def made_ready(types: Sequence[ObjectType], cells: Sequence[ViewCells], looks: int) -> Ready:
    """Σ of these types and their index."""
    kb = knowledge_base(types, type_names(looks), EASY)
    dv = distinctiveness(instance_counts(types))
    start = process_time()
    indices = [oriented_index(kind, dv, of_kind) for kind, of_kind in zip(types, cells, strict=True)]
    shared = pair_index(indices)
    return Ready(kb, dv, {index.object_type.name: index for index in indices}, shared, process_time() - start)


def first(ready: Ready, count: int) -> Ready:
    """The first so many types alone: what would be made of them, taken from what was made of all."""
    kb = knowledge_base(ready.kb.types[:count], ready.kb.appearance_types, EASY)
    dv = distinctiveness(instance_counts(kb.types))
    indices = [oriented_index(kind, dv, ready.indices[kind.name].cells) for kind in kb.types]
    whole = ready.shared
    some = whole.entry < np.uint64(count) << np.uint64(40)
    sights = Sights(*(getattr(whole.sights, field.name)[:count] for field in fields(Sights)))
    shared = PairIndex(tuple(indices), whole.looks, sights, whole.key[some], whole.entry[some], whole.turned[some])
    return Ready(kb, dv, {index.object_type.name: index for index in indices}, shared, 0.0)


def index_bytes(ready: Ready) -> dict[str, float]:
    """Bytes a type: of the pairs, of the sights, of the view cells."""
    shared, count = ready.shared, len(ready.indices)
    sights = shared.sights
    parts = {
        "pairs": (shared.key, shared.entry, shared.turned),
        "sights": (sights.feature, sights.looks, sights.xy, sights.angle, sights.diameter),
        "cells": [array for cells in shared.cells for array in (cells.xy, cells.visible, cells.arms)],
    }
    return {name: sum(array.nbytes for array in arrays) / count for name, arrays in parts.items()}


def disk_bytes(count: int, seed: int) -> float:
    """Bytes a type of the folder in which the index of so many types is kept."""
    from plogic.match.oriented.oriented_models import ready

    kb = random_types(count, FEATURES, LOOKS, np.random.default_rng([seed, LOOKS]), EASY)
    with tempfile.TemporaryDirectory(prefix="plogic-scale-") as folder:
        ready(kb.types, distinctiveness(instance_counts(kb.types)), Path(folder))
        return sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file()) / count


def object_bytes(count: int, seed: int) -> float:
    """Bytes of memory a type that Σ itself takes, as Python's objects.

    Twice ``count`` types take so much more than ``count``.
    """
    random_types(
        1, FEATURES, LOOKS, np.random.default_rng([seed, LOOKS]), EASY
    )  # what is imported, or made once, is no type's
    held = []
    for number in (count, 2 * count):
        tracemalloc.start()
        kept = random_types(number, FEATURES, LOOKS, np.random.default_rng([seed, LOOKS]), EASY)
        held.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        del kept
    return (held[1] - held[0]) / count


def _relabelled(kind: ObjectType, looks: int) -> ObjectType:
    names = type_names(looks)
    frames = np.array([feature.rotation for feature in kind.features])
    fewer = [names[int(name[1:]) % looks] for name in kind.lobes.types]
    return made(kind.name, kind.surface, kind.lobes.at, frames, fewer, np.full(len(fewer), HALF_ANGLE))
