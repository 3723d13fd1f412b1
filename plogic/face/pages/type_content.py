"""What the page knows of an object type, as plain data: ``{"format": "type_page/1", ...}``; m and rad, object frame.

Feature types, appearance types and parts are lists; features and lobes name them by their index. Lobes stand in the
order of features.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kb.shown.cautions import learned_summary
from kb.shown.show import part_of_features, part_rows
from plogic.face.pages.packed import floats, shorts
from plogic.face.pages.type_surface import surface_document
from plogic.measures.distinctiveness import distinctiveness, instance_counts

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from kb.clouds.learned import LearnedCloud

MOST_FEATURES = 6_000
"""That are drawn."""
MOST_LOBES = 24_000
"""That are drawn; of a type with more, evenly chosen features stand for all."""


def type_document(kb: KnowledgeBase, kind: ObjectType) -> dict[str, Any]:
    """The page's data of one type of the KB. The same KB gives the same data."""
    surface, notes = surface_document(kind)
    kept = chosen(kind)
    if len(kept) < len(kind.seen_features):
        notes.append(
            f"It has {len(kind.seen_features)} features with {len(kind.lobes.types)} lobes; {len(kept)} features, evenly chosen, are drawn and "
            f"counted (at most {MOST_FEATURES}, with at most {MOST_LOBES} lobes)."
        )
    names = _names(kind)
    types = {name: i for i, name in enumerate(names)}
    return {
        "format": "type_page/1",
        "kb": {"name": kb.name, "digest": kb.digest, "f_ref": kb.f_ref},
        "type": {
            "name": kind.name,
            "opaque": kind.opaque,
            "detector": kind.learned.detector if kind.learned is not None else None,
        },
        "lines": list(learned_summary(kind).lines) if kind.learned is not None else [],
        "types": [*_types(kb, kind, names)],
        "parts": [row | {"counts": [[types[name], n] for name, n in row["counts"].items()]} for row in part_rows(kind)],
        "features": _features(kind, kept, types),
        "lobes": _lobes(kind, kept),
        "surface": surface,
        "notes": notes,
    }


def chosen(kind: ObjectType) -> NDArray[np.int64]:
    """Indices of the features that are drawn: all of them, or as many evenly chosen ones as stay within the limits."""
    total = len(kind.seen_features)
    lobes = np.bincount(kind.lobes.feature, minlength=total)
    kept = np.arange(total)
    while len(kept) > MOST_FEATURES or lobes[kept].sum() > MOST_LOBES:
        kept = np.linspace(0, total - 1, min(MOST_FEATURES, len(kept) * 9 // 10)).round().astype(np.int64)
    return kept


def _names(kind: ObjectType) -> list[str]:
    return sorted({feature.type for feature in kind.all_features})


def _types(kb: KnowledgeBase, kind: ObjectType, names: Iterable[str]) -> Iterable[list[Any]]:
    """[name, Feature nodes of this type here, in the whole KB, dv, hit rate, sigma in pixels] of each feature type."""
    here, everywhere = instance_counts([kind]), instance_counts(kb.types)
    dv = distinctiveness(everywhere)
    for name in names:
        yield [
            name,
            here[name],
            everywhere[name],
            round(dv[name], 6),
            round(kb.rates.hit.get(name, 0.0), 4),
            round(kb.rates.sigma_of(name), 4),
        ]


def _features(kind: ObjectType, kept: NDArray[np.int64], types: dict[str, int]) -> dict[str, Any]:
    features = [kind.seen_features[i] for i in kept]
    part = part_of_features(kind)
    return {
        "names": [feature.name for feature in features],
        "type": shorts([types[feature.type] for feature in features]),
        "part": shorts([part[i] for i in kept]),
        "at": floats([feature.at for feature in features]),
        "sigma": floats(kind.learned.sigma[kept]) if kind.learned is not None else None,
        "sides": None if kind.learned is None else _sides(kind.learned, kept),
        "of": len(kind.seen_features),
    }


def _sides(cloud: LearnedCloud, kept: NDArray[np.int64]) -> dict[str, str] | None:
    """Which of the features are sides of edges and, of each as its surest lobe saw it, two unit vectors: along its edge, and across towards it."""
    lobes = np.flatnonzero(cloud.sided & np.isin(cloud.feature, kept))
    surest = lobes[np.lexsort((-cloud.hit[lobes], cloud.feature[lobes]))]
    feature, first = np.unique(cloud.feature[surest], return_index=True)
    rows = surest[first]
    strokes = np.column_stack([np.cross(cloud.axis[rows], cloud.up[rows]), cloud.up[rows]])
    return {"feature": shorts(np.searchsorted(kept, feature)), "strokes": floats(strokes)} if len(rows) else None


def _lobes(kind: ObjectType, kept: NDArray[np.int64]) -> dict[str, Any]:
    table = kind.lobes
    rows = np.flatnonzero(np.isin(table.feature, kept))
    rows = rows[np.argsort(table.feature[rows], kind="stable")]
    looks = sorted({table.types[i] for i in rows})
    index = {name: i for i, name in enumerate(looks)}
    return {
        "looks": looks,
        "look": shorts([index[table.types[i]] for i in rows]),
        "feature": shorts(np.searchsorted(kept, table.feature[rows])),
        "axis": floats(table.axis[rows]),
        "half_angle": floats(np.arccos(np.clip(table.cos_half[rows], -1.0, 1.0))),
        "r_min": floats(table.r_min[rows]),
        "r_max": floats(table.r_max[rows]),
        "hit": floats(kind.learned.hit[rows]) if kind.learned is not None else None,
        "of": len(table.types),
    }
