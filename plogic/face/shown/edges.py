"""The edges of posed objects in the picture: outlines and creases, cut where what hides them changes.

``edges_of(document)`` gives the ``Stroke``s of each hypothesis, such as ``Stroke([[3.0, 4.0], [9.5, 4.0]], inner=False,
self_hidden=False, hidden_by=("h1",))``. A stroke is hidden as a feature is: by its own object, or by another that
stands before it, which is Behind (D13) with the rays of ``geometry.visibility`` on the meshes that the document
carries; rivals are in no world together. Which of the others are present is for the reader to say, for it differs from
world to world.

An outline's depth is that of its object's surface just inside of it. Creases are drawn of a mesh that has few; of a
smooth or a scanned one its ``folds``, which depend on the view. Of a type without a mesh nothing is known to be hidden,
and of a rejected hypothesis only what it hides of itself: it is in no world with others.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.camera import Camera, camera_from_dict
from geometry.errors import GeometryError
from geometry.frames import inverse, rotate, transform_points
from geometry.visibility.outline import image_area
from geometry.visibility.rays import RayMesh, behind
from plogic.face.shown.folds import folds
from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow

STEP = 3.0
"""Pixels between two places of an edge that are looked at."""
INSIDE = 1.0
"""Pixels from an outline to the place inside of it whose depth it has."""
RIM = 2.0
"""Pixels; a crease so near to the outline is the outline."""
MOST_CREASES = 80
"""Of a mesh whose creases are drawn."""
FLAT = 0.94
"""Cosine of the angle between two facets above which their edge is no crease."""
MOST_HIDING = 100
"""Hypotheses that are asked whether they hide others; of more, the first."""
LARGEST = 1e5
"""Pixels from the image's corner, where what reaches farther is taken to end."""
_EXACT = 0.15
"""Pixels by which a stroke may leave out places on its way."""


NONE = np.zeros((0, 2, 3))
"""No creases."""


class Stroke(NamedTuple):
    """A line in pixels, (N, 2), all of it hidden by the same."""

    points: list[list[float]]
    inner: bool
    """Whether it is a crease; else it is of the outline."""
    self_hidden: bool
    hidden_by: tuple[str, ...]
    """Ids of hypotheses, in the document's order."""


class _Line(NamedTuple):
    """Places along one edge: ``uv`` (N, 2) pixels and ``points`` (N, 3) m, camera frame; NaN where it has no depth."""

    uv: Floats
    points: Floats
    inner: bool


Row = HypothesisRow | RejectedRow


def edges_of(document: Interpretation) -> dict[str, list[Stroke]]:
    """The strokes of each hypothesis by its id, the outline's first; of nothing that has no outline."""
    try:
        camera = camera_from_dict(document.get("camera"))
    except GeometryError:
        return {}
    rows = [h for h in document.get("hypotheses", []) if _rings(h)]
    meshes = _meshes(document, {h["type"] for h in rows})
    lines = {h["id"]: [*_outline(h, meshes.get(h["type"]), camera)] for h in rows}
    inner = {name: creases(np.asarray(mesh.vertices), mesh.triangles) for name, mesh in meshes.items()}
    for h in rows:
        if len(inner.get(h["type"], ())) <= MOST_CREASES:
            lines[h["id"]] += _creases(h, inner.get(h["type"], NONE), camera)
        elif h["status"] != "rejected":
            lines[h["id"]] += _folds(h, meshes[h["type"]], camera)
    able = [h for h in rows if h["status"] != "rejected" and h.get("opaque", True) and h["type"] in meshes]
    apart = {frozenset(fact["args"]) for fact in document.get("facts", []) if fact["fact"] == "rival"}
    found = {}
    for h in rows:
        others = [g for g in able[:MOST_HIDING] if g["id"] != h["id"] and {g["id"], h["id"]} not in apart]
        beside = [g for g in others if h["status"] != "rejected" and _near(g, h)]
        found[h["id"]] = _strokes(h, lines[h["id"]], beside, meshes)
    return found


def _meshes(document: Interpretation, names: set[str]) -> dict[str, RayMesh]:
    """The surfaces of the types that have a mesh with an extent."""
    found: dict[str, RayMesh] = {}
    for name, mesh in sorted(document.get("assets", {}).get("meshes", {}).items()):
        if name in names:
            try:
                found[name] = RayMesh(mesh["vertices"], mesh["triangles"])
            except GeometryError:
                continue  # a mesh of no triangle hides nothing
    return found


def _pose(h: Row) -> Floats:
    return np.asarray(h["T_camera_object"], dtype=float)


def _rings(h: Row) -> list[Floats]:
    """The rings of the outline that are any, closed, (N, 2) pixels."""
    rings = [np.array([*ring, *ring[:1]], dtype=float) for ring in h.get("outline", [])]
    return [np.clip(ring, -LARGEST, LARGEST) for ring in rings if len(ring) > 3 and np.isfinite(ring).all()]


def _outline(h: Row, mesh: RayMesh | None, camera: Camera) -> Iterator[_Line]:
    """The rings of the outline as far as they are in the image."""
    for ring in _rings(h):
        shown = shapely.intersection(shapely.LineString(ring), image_area(camera))
        for part in shapely.get_parts(shapely.line_merge(shown) if shown.geom_type == "MultiLineString" else shown):
            if part.geom_type == "LineString" and not part.is_empty:
                uv = shapely.get_coordinates(shapely.segmentize(part, STEP))
                yield _Line(uv, _at_depth(uv, h, mesh, camera), inner=False)


def _at_depth(uv: Floats, h: Row, mesh: RayMesh | None, camera: Camera) -> Floats:
    """Places (N, 3) m on the lines of sight of an outline, as deep as the surface is just inside of it."""
    if mesh is None:
        return np.full((len(uv), 3), np.nan)
    along = np.gradient(uv, axis=0)
    across = INSIDE * along[:, ::-1] * [1, -1] / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
    object_from_camera = inverse(_pose(h))
    depths = np.stack(
        [
            mesh.first_hit(object_from_camera[None, :3, 3], rotate(object_from_camera, camera.rays(uv + side)))
            for side in (across, -across)
        ]
    )
    depth = depths.min(axis=0)
    hit = np.flatnonzero(np.isfinite(depth))
    if not len(hit):
        return np.full((len(uv), 3), np.nan)
    return np.asarray(camera.rays(uv) * np.interp(np.arange(len(uv)), hit, depth[hit])[:, None])


def _creases(h: Row, ends: Floats, camera: Camera) -> Iterator[_Line]:
    """Of the creases (E, 2, 3) of its surface what is inside of the outline and in the image."""
    rings = shapely.MultiLineString(_rings(h))
    for start, end in transform_points(_pose(h), ends):
        if min(start[2], end[2]) <= 0:
            continue
        span = camera.project(np.stack([start, end]))
        length = float(np.linalg.norm(np.clip(span[1], -LARGEST, LARGEST) - np.clip(span[0], -LARGEST, LARGEST)))
        count = int(np.clip(np.nan_to_num(length) / STEP, 2, 1000)) + 1
        points = _evenly_seen(start, end, count)
        uv = camera.project(points)
        inside = camera.contains(uv) & (shapely.distance(shapely.points(np.nan_to_num(uv)), rings) > RIM)
        for run in _runs(inside):
            if inside[run.start]:
                yield _Line(uv[run], points[run], inner=True)


def _folds(h: Row, mesh: RayMesh, camera: Camera) -> Iterator[_Line]:
    """Of the folds of its surface what is inside of the outline and in the image."""
    rings = shapely.MultiLineString(_rings(h))
    for points in folds(mesh, _pose(h)):
        uv = camera.project(points)
        inside = camera.contains(uv) & (shapely.distance(shapely.points(np.nan_to_num(uv)), rings) > RIM)
        yield from (_Line(uv[run], points[run], inner=True) for run in _runs(inside) if inside[run.start])


def _evenly_seen(start: Floats, end: Floats, count: int) -> Floats:
    """So many places (N, 3) between two that are about evenly apart in the picture."""
    share = np.linspace(0, 1, count)[:, None]
    along = share * start[2] / ((1 - share) * end[2] + share * start[2])
    return np.asarray(start + along * (end - start))


def creases(vertices: Floats, triangles: NDArray[Any]) -> Floats:
    """(E, 2, 3): the edges at which facets meet at an angle, or that one facet alone has. ``vertices`` (V, 3)."""
    places, same = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    facets = same.reshape(-1)[triangles]
    normals = np.cross(places[facets[:, 1]] - places[facets[:, 0]], places[facets[:, 2]] - places[facets[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    around = np.sort(np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]]), axis=1)
    order = np.lexsort(around.T[::-1])
    around, owner = around[order], np.tile(np.arange(len(facets)), 3)[order]
    first = np.flatnonzero(np.r_[True, (np.diff(around, axis=0) != 0).any(axis=1)])
    count = np.diff(np.r_[first, len(around)])
    leader = np.repeat(owner[first], count)
    steep = np.einsum("ij,ij->i", normals[owner], normals[leader]) < FLAT
    kept = (count == 1) | np.logical_or.reduceat(steep, first)
    return np.asarray(places[around[first[kept]]])


def _strokes(h: Row, lines: Sequence[_Line], beside: Sequence[Row], meshes: Mapping[str, RayMesh]) -> list[Stroke]:
    """The lines, cut where what hides them changes; those ``beside`` may hide them."""
    if not lines:
        return []
    points = np.concatenate([line.points for line in lines])
    own = np.concatenate([np.full(len(line.uv), line.inner) for line in lines])
    if h["type"] in meshes and h.get("opaque", True):
        own &= behind(points, meshes[h["type"]], _pose(h))
    else:
        own[:] = False
    masks = {g["id"]: behind(points, meshes[g["type"]], _pose(g)) for g in beside}
    before = {name: mask for name, mask in masks.items() if mask.any()}
    table, found, begin = np.column_stack([own, *before.values()]), list[Stroke](), 0
    for line in lines:
        hidden = _settled(table[begin : begin + len(line.uv)])
        begin += len(line.uv)
        for run in _runs(hidden):
            row = hidden[run.start]
            names = tuple(name for name, there in zip(before, row[1:], strict=True) if there)
            uv = line.uv[run.start : run.stop + 1]  # to where the next one begins
            if len(uv) > 1:
                found.append(Stroke(_thinned(uv), line.inner, bool(row[0]), names))
    return found


def _near(g: Row, h: Row) -> bool:
    """Whether the boxes of two outlines meet."""
    (low, high), (start, stop) = (
        (np.min(uv, axis=0), np.max(uv, axis=0)) for uv in (np.concatenate(_rings(x)) for x in (g, h))
    )
    return bool((low <= stop).all() and (start <= high).all())


def _settled(hidden: Mask) -> Mask:
    """(N, K) without what holds at one place alone and on neither side of it."""
    calm = hidden.copy()
    alone = (hidden[:-2] == hidden[2:]) & (hidden[1:-1] != hidden[:-2])
    calm[1:-1][alone] = hidden[:-2][alone]
    return calm


def _runs(rows: Mask) -> Iterator[slice]:
    """Stretches of equal rows (N,) or (N, K)."""
    flat = rows.reshape(len(rows), -1)
    cuts = np.flatnonzero((flat[1:] != flat[:-1]).any(axis=1)) + 1
    return (slice(int(a), int(b)) for a, b in pairwise([0, *cuts, len(rows)]) if b > a)


def _thinned(uv: Floats) -> list[list[float]]:
    line = shapely.simplify(shapely.LineString(uv), _EXACT)
    return [[round(float(u), 1), round(float(v), 1)] for u, v in shapely.get_coordinates(line)]
