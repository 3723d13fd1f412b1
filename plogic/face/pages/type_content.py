"""What the page knows of an object type, as plain data: ``{"format": "type_page/1", ...}``; m and rad, object frame.

Feature types, appearance types and parts are lists; features and lobes name them by their index. Lobes stand in the
order of features.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud
from kb.shown.cautions import learned_summary
from kb.shown.show import part_of_features, part_rows
from plogic.face.pages.one_file import PageParts, one_file
from plogic.face.pages.standing import standing_document
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.run.painted import Drawn, coarser, floats, painted_mesh, shorts, texture_picture

LARGEST_PICTURE = 600_000
"""Bytes of the texture as JPEG."""
LONGEST_SIDE = 2048
"""Most pixels of the texture's sides."""
COARSE = 0.5
"""The page says so where the texture has less than this share of its pixels."""


def surface_document(kind: ObjectType) -> tuple[dict[str, Any] | None, list[str]]:
    """The surface as plain data, None of a type without one; and what had to be left out, a sentence each."""
    if kind.surface is None:
        return None, ["It has no mesh: only its features are drawn."]
    painted, notes = painted_mesh(kind)
    whole = Drawn(kind.surface.vertices, kind.surface.triangles)
    if painted is not None:
        whole = Drawn(painted.vertices, painted.triangles, painted.uv)
    drawn = coarser(whole)
    if len(drawn.triangles) < len(whole.triangles):
        notes.append(f"The mesh has {len(whole.triangles)} triangles; it is drawn with {len(drawn.triangles)}.")
    picture = None
    if painted is not None and painted.texture is not None:
        picture, size = texture_picture(painted.texture, LARGEST_PICTURE, LONGEST_SIDE)
        height, width = painted.texture.shape[:2]
        if size[0] * size[1] < COARSE * width * height:
            notes.append(f"The texture has {width} by {height} pixels; it is drawn with {size[0]} by {size[1]}.")
    document = {
        "vertices": floats(drawn.vertices),
        "triangles": shorts(drawn.triangles),
        "uv": None if drawn.uv is None else floats(drawn.uv),
        "picture": picture,
    }
    return document, notes


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
    names = sorted({feature.type for feature in kind.all_features})
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
        "stands": standing_document(kind),
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
    """Which of the features are sides of edges and, of each as its surest lobe saw it, two unit vectors.

    Along its edge, and across towards it.
    """
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


PARTS = PageParts(
    folder="type",
    scripts=(
        "model.js",
        "eye.js",
        "lobes.js",
        "webgl.js",
        "canvas.js",
        "panels.js",
        "feature.js",
        "map.js",
        "stage.js",
    ),
    first="feature",
    unscripted="<code>plogic kb show</code> without <code>--html</code> prints the same type as text.",
)


def type_page(kb: KnowledgeBase, kind: ObjectType) -> str:
    """Return the page of one object type of the KB. The same KB gives the same bytes."""
    return one_file(PARTS, kind.name, type_document(kb, kind))
