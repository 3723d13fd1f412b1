"""All types that were written by hand, made ready for the search of all at once; kept on disk between runs, and mapped from there.

* ``ready(types, dv, folder)``: the indices of the types, and the index over them
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from plogic.base.remembered import arrays_of
from plogic.match.hand.view_cells import remade
from plogic.match.oriented.oriented_index import oriented_index
from plogic.match.oriented.pair_index import PairIndex, looks_of, pair_index
from plogic.match.oriented.ready_key import key_of
from plogic.match.oriented.sights import Sights

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType

    Arrays = Mapping[str, NDArray[Any]]

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
