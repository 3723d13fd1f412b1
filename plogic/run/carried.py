"""What an interpretation carries along.

The image and the meshes, up to a stated size, and how its types are seen (§2.7).

How a type is seen, from where which feature is reported as what and how often, is what looking ahead reads.

Types written by hand are carried whole. Of a learned type, which has thousands of lobes, ``MOST_LOBES`` are: the surest
of each direction of view in turn; how many were left out is said.
"""

import base64
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.facts.carried_rows import AssetsRow, MeshRow, TypeRow
from plogic.facts.document import SensingRow
from plogic.facts.hypothesis import part_facts
from plogic.facts.interpretation import type_of
from plogic.facts.situation import Reading, Reconsider, Situation
from plogic.measures.distinctiveness import distinctiveness, instance_counts

Floats = NDArray[np.float64]

MOST_LOBES = 1500
"""Of one type: some 60 bytes each."""
DIRECTIONS = np.array(
    [[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)], float
)
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
DIRECTIONS.setflags(write=False)


def sensing_document(kb: KnowledgeBase) -> SensingRow:
    """What holds of the detector whatever is there.

    Focal length of reference, tolerance (pixels), data of clutter an image by type.
    """
    return {
        "f_ref": kb.f_ref,
        "match_tolerance": kb.rates.match_tolerance,
        "clutter": dict(sorted(kb.rates.clutter.items())),
    }


def types_document(types: Mapping[str, ObjectType], kb: KnowledgeBase) -> dict[str, TypeRow]:
    """By type: its ``features`` as [id, type, x, y, z], its ``looks``, and ``lobes`` as rows of numbers.

    A lobe is [feature, look, axis x, y, z, half angle, least and greatest distance, hit rate]; metres, radians, object
    frame, rounded. ``facets`` and ``faces``: those of its surface whose corners are
    features.
    """
    return {name: _table(kind, kb) for name, kind in sorted(types.items())}


def sigma(kb: KnowledgeBase, reading: Reading, reconsider: Reconsider) -> Situation:
    """Σ without any Δ or Γ: what the program of a knowledge base says (§9.8)."""
    kinds = {kind.name: kind for kind in kb.types}
    rows = types_document(kinds, kb)
    types = {
        name: replace(
            type_of(rows[name]),
            features=tuple((feature.name, feature.type) for feature in kind.seen_features),
            parts=part_facts(kind),
            opaque=kind.opaque,
        )
        for name, kind in kinds.items()
    }
    return Situation(
        reading,
        (),
        (),
        reconsider,
        types=types,
        priors=dict(kb.rates.prior),
        dv=distinctiveness(instance_counts(kb.types)),
        hit_rates=dict(kb.rates.hit),
        rules=kb.rules or "",
    )


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
    if kind.facets:
        document["facets"] = [list(corners) for corners in kind.facets]
    if kind.faces:
        document["faces"] = [list(corners) for corners in kind.faces]
    return {**document, "left_out": {"lobes": len(hit) - len(kept)}} if len(kept) < len(hit) else document


def _hit(kind: ObjectType, kb: KnowledgeBase) -> NDArray[np.float64]:
    """(L,) how often each lobe is reported: measured, or that of the feature's type."""
    if kind.learned is not None:
        return np.asarray(kind.learned.hit)
    of_feature = np.array([kb.rates.hit.get(feature.type, 0.8) for feature in kind.seen_features])
    return np.asarray(of_feature[kind.lobes.feature])


def _surest(axis: NDArray[np.float64], hit: NDArray[np.float64]) -> NDArray[np.intp]:
    """At most ``MOST_LOBES`` lobes in their order: the surest of each direction, then the second of each, and so on."""
    direction = (axis @ DIRECTIONS.T).argmax(axis=1)
    order = np.lexsort((-hit, direction))
    first = np.searchsorted(direction[order], direction[order], side="left")
    turn = np.empty(len(hit), np.intp)
    turn[order] = np.arange(len(hit)) - first
    return np.sort(np.lexsort((-hit, turn))[:MOST_LOBES])


LARGEST_PNG = 768 * 2**10
"""Bytes; a larger image is carried as JPEG."""
LONGEST_SIDE = 1280
"""Pixels; a larger image is carried smaller."""
MOST_TRIANGLES = 4000
"""Of a carried mesh; a larger one is carried coarser."""
GRIDS = (80, 56, 40, 28, 20, 14, 10, 7)
"""Cells to the longest side in which a large mesh's vertices are made one, finest first, until its triangles are few
enough."""


def image_asset(image: NDArray[np.uint8] | None) -> AssetsRow:
    """``{"image": {...}}`` of a BGR picture (H, W, 3), or nothing.

    The size given is the original's, so that pixels keep their meaning.
    """
    if image is None:
        return {}
    height, width = image.shape[:2]
    shrink = LONGEST_SIDE / max(height, width)
    small = image if shrink >= 1.0 else cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    kind: Literal["image/png", "image/jpeg"]
    kind, data = "image/png", cv2.imencode(".png", small)[1]
    if data.size > LARGEST_PNG:
        kind, data = "image/jpeg", cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 88])[1]
    text = base64.b64encode(data.tobytes()).decode()
    return {"image": {"media_type": kind, "width": width, "height": height, "base64": text}}


def mesh_assets(types: Mapping[str, ObjectType]) -> AssetsRow:
    """``{"meshes": {type: {"vertices", "triangles"}}}`` in metres, object frame, to 0.1 mm.

    Of a coarser one how far off it may be, ``slack``, m.
    """
    meshes: dict[str, MeshRow] = {}
    for name, object_type in sorted(types.items()):
        surface = object_type.surface
        if surface is not None:
            vertices, triangles, slack = _carried(surface.vertices, surface.triangles)
            meshes[name] = {"vertices": np.round(vertices, 4).tolist(), "triangles": triangles.tolist()}
            if slack != 0.0:
                meshes[name]["slack"] = round(slack, 5)
    return {"meshes": meshes}


def _carried(
    vertices: NDArray[np.float64], triangles: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.intp], float]:
    """The mesh, few enough triangles of it, and the diagonal of the cells that its vertices were made one in.

    0 where they were not.
    """
    if len(triangles) <= MOST_TRIANGLES:
        return vertices, triangles, 0.0
    for cells in GRIDS:
        fewer = _clustered(vertices, triangles, cells)
        if len(fewer[1]) <= MOST_TRIANGLES:
            break
    return *fewer, float(np.sqrt(3.0) * np.ptp(vertices, axis=0).max() / cells)


def _clustered(vertices: Floats, triangles: NDArray[np.intp], cells: int) -> tuple[Floats, NDArray[np.int64]]:
    """The mesh with the vertices of each cell of a grid, ``cells`` to its longest side, made one: their mean."""
    cell = cells_of(vertices, cells)
    faces = cell[triangles]
    return means(vertices, cell), faces[whole(faces)]


def cells_of(vertices: Floats, cells: int) -> NDArray[np.int64]:
    """(V,) the number of the cell of a grid, ``cells`` to the longest side, that each of ``vertices`` (V, 3) is in."""
    low = vertices.min(axis=0)
    side = float((vertices.max(axis=0) - low).max()) / cells or 1.0
    return alike(np.floor((vertices - low) / side))


def alike(rows: Floats) -> NDArray[np.int64]:
    """(N,) the number of each row among the different ones."""
    return np.unique(rows.astype(np.int64), axis=0, return_inverse=True)[1].reshape(-1)


def means(values: Floats, group: NDArray[np.int64]) -> Floats:
    """(G, D) the mean of the ``values`` (N, D) of each ``group`` (N,)."""
    count = np.bincount(group)
    return np.stack([np.bincount(group, values[:, i]) / count for i in range(values.shape[1])], axis=1)


def whole(faces: NDArray[np.int64]) -> NDArray[np.intp]:
    """The indices, in order, of ``faces`` (T, 3) with three different corners, each set of corners once."""
    kept = np.flatnonzero((faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2]))
    return kept[np.sort(np.unique(np.sort(faces[kept], axis=1), axis=0, return_index=True)[1])]
