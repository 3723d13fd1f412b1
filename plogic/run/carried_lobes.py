"""What an interpretation carries along of its types to look ahead by: from where which feature is reported as what, and how often (§2.7).

Types written by hand are carried whole. Of a learned type, which has thousands of lobes, ``MOST_LOBES`` are: the surest
of each direction of view in turn; how many were left out is said.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.facts.document import SensingRow, TypeRow

MOST_LOBES = 1500
"""Of one type: some 60 bytes each."""
DIRECTIONS = np.array(
    [[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)], float
)
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
DIRECTIONS.setflags(write=False)


def sensing_document(kb: KnowledgeBase) -> SensingRow:
    """What holds of the detector whatever is there: focal length of reference, tolerance (pixels), data of clutter an image by type."""
    return {
        "f_ref": kb.f_ref,
        "match_tolerance": kb.rates.match_tolerance,
        "clutter": dict(sorted(kb.rates.clutter.items())),
    }


def types_document(types: Mapping[str, ObjectType], kb: KnowledgeBase) -> dict[str, TypeRow]:
    """By type: its ``features`` as [id, type, x, y, z], the appearance types ``looks``, and ``lobes`` as rows of numbers.

    A lobe is [feature, look, axis x, y, z, half angle, least and greatest distance, hit rate]; metres, radians, object
    frame, rounded.
    """
    return {name: _table(kind, kb) for name, kind in sorted(types.items())}


def _table(kind: ObjectType, kb: KnowledgeBase) -> TypeRow:
    table, hit = kind.lobes, _hit(kind, kb)
    kept = _surest(table.axis, hit) if kind.learned is not None else np.arange(len(hit))
    used, feature = np.unique(table.feature[kept], return_inverse=True)
    looks = sorted({table.types[lobe] for lobe in kept})
    place = {name: i for i, name in enumerate(looks)}
    half = np.arccos(np.clip(table.cos_half, -1.0, 1.0))
    rows = np.column_stack([table.axis, half, table.r_min, table.r_max, hit])[kept].round(4).tolist()
    seen = [kind.seen_features[f] for f in used.tolist()]
    document: TypeRow = {
        "features": [[f.name, f.type, *np.round(f.at, 5).tolist()] for f in seen],
        "looks": looks,
        "lobes": [
            [f, place[table.types[lobe]], *row]
            for f, lobe, row in zip(np.asarray(feature).reshape(-1).tolist(), kept, rows, strict=True)
        ],
        "measured": kind.learned is not None,
    }
    return {**document, "left_out": {"lobes": len(hit) - len(kept)}} if len(kept) < len(hit) else document


def _hit(kind: ObjectType, kb: KnowledgeBase) -> NDArray[np.float64]:
    """(L,) how often each lobe is reported: measured, or that of the feature's type."""
    if kind.learned is not None:
        return np.asarray(kind.learned.hit)
    of_feature = np.array([kb.rates.hit.get(feature.type, 0.8) for feature in kind.features])
    return np.asarray(of_feature[kind.lobes.feature])


def _surest(axis: NDArray[np.float64], hit: NDArray[np.float64]) -> NDArray[np.intp]:
    """At most ``MOST_LOBES`` lobes in their order: the surest of each direction, then the second of each, and so on."""
    direction = (axis @ DIRECTIONS.T).argmax(axis=1)
    order = np.lexsort((-hit, direction))
    first = np.searchsorted(direction[order], direction[order], side="left")
    turn = np.empty(len(hit), np.intp)
    turn[order] = np.arange(len(hit)) - first
    return np.sort(np.lexsort((-hit, turn))[:MOST_LOBES])
