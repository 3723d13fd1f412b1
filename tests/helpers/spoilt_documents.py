"""Documents with one change anywhere, to be refused or not."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np


def spoilt(document: Any, rng: np.random.Generator) -> Any:
    """A copy in which one value, anywhere, is another, or is gone, or has a neighbour."""

    def one_of(some: Any) -> Any:
        return some[int(rng.integers(len(some)))]

    document = copy.deepcopy(document)
    at, key = document, one_of(sorted(document))
    while isinstance(at[key], (list, dict)) and at[key] and rng.random() < 0.85:
        at = at[key]
        key = one_of(sorted(at)) if isinstance(at, dict) else int(rng.integers(len(at)))
    what = one_of(["gone", "other", "neighbour"])
    if what == "neighbour" and isinstance(at, dict):
        at["strange"] = 1
    elif what == "gone" and isinstance(at, dict):
        del at[key]
    else:
        at[key] = one_of([None, True, 1, -1, 2.5, "text", "", [], {}, [1.5, 2.5], 1e99])
    return document
