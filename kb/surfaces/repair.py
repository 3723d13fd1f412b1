"""A mesh as it came to a surface that can be reasoned with.

Welded, cleaned, closed where it can be, outward, and no larger than needed.

Vocabulary: ``Repaired``, the surface and the numbers of what was done.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.visibility.outline import is_closed
from kb.errors import IntakeError, SurfaceError
from kb.surfaces.closing import closed_up, joined_twice, rims, turned_outward
from kb.surfaces.nearness import Nearness, spread
from kb.surfaces.surface import Surface, welded


@dataclass(frozen=True, eq=False)
class Repaired:
    """``surface``, m.

    ``vertices``, ``triangles``: what the source had; ``welded`` vertices that were joined to others; ``dropped``
    triangles that were degenerate or there twice; ``holes`` filled and ``left`` open; ``deviation`` m of the simplified
    surface.
    """

    surface: Surface
    vertices: int
    triangles: int
    welded: int
    dropped: int
    holes: int
    left: int
    deviation: float


def repaired(vertices: Floats, triangles: Ints) -> Repaired:
    """The surface of ``vertices`` (V, 3) m and ``triangles`` (T, 3).

    Raises:
        IntakeError: where nothing is left, all the triangles being degenerate.
    """
    try:
        joined = welded(vertices, triangles)
    except SurfaceError as error:
        raise IntakeError(f"no surface can be made of it: {error}") from error
    places, facets, holes, left = closed_up(joined.vertices, joined.triangles)
    smaller, off = simplified(Surface(places, facets))
    lost = len(triangles) - len(joined.triangles) + joined_twice(joined.triangles)
    return Repaired(
        smaller, len(vertices), len(triangles), len(vertices) - len(joined.vertices), lost, holes, left, off
    )


FEW, MANY = 4_000, 16_000
"""Triangles of the geometry that is kept: at most the few, or, where these would be too far from the mesh, up to the
many."""
DEVIATIONS = (0.0005, 0.001, 0.002, 0.003)
"""How far it may be from the mesh, as shares of the diameter: the first that does with the few triangles; the last is
too far."""
PROBES = 5_000
"""Points that the deviation is measured at."""
AGGRESSION = 3
"""How coarsely quadric decimation steps: 0 is fine and seldom gets there, 10 coarse."""


def simplified(surface: Surface) -> tuple[Surface, float]:
    """The surface with at most ``FEW`` triangles, and how far it then is at most, m, of many points.

    With up to ``MANY``, where it would be too far.

    What is too far: the last of ``DEVIATIONS``. Where even ``MANY`` triangles are farther, so be it: the distance
    tells.
    """
    if len(surface.triangles) <= FEW:
        return surface, 0.0
    capped = _capped(surface)
    return _by_quadrics(surface) if capped is None else _within_tolerance(surface, *capped)


def _capped(surface: Surface) -> tuple[Floats, Ints] | None:
    """Vertices, those of the caps last, and the caps' triangles (C, 3), which close the surface.

    None where they do not.
    """
    caps, middles = [], [surface.vertices]
    for number, loop in enumerate(rims(surface.triangles) if not surface.closed else ()):
        caps.append(np.stack([np.roll(loop, -1), loop, np.full(len(loop), len(surface.vertices) + number)], axis=1))
        middles.append(surface.vertices[loop].mean(axis=0)[None])
    extra = np.concatenate(caps) if caps else np.zeros((0, 3), dtype=np.int64)
    whole = is_closed(np.concatenate([surface.triangles, extra]))
    return (np.concatenate(middles), extra) if whole else None


def _within_tolerance(surface: Surface, vertices: Floats, caps: Ints) -> tuple[Surface, float]:
    """By manifold3d: a subset of the vertices.

    Each step moves nothing by more than the tolerance, several may add up a little.
    """
    from manifold3d import Manifold, Mesh64

    name = Manifold.reserve_ids(
        2
    )  # of the surface's triangles; the caps' is the next, and between the two no edge is lost
    facets = np.concatenate([surface.triangles, caps]).astype(np.uint64)
    runs = np.array([0, 3 * len(surface.triangles), 3 * len(facets)], dtype=np.uint64)
    names = np.array([name, name + 1], dtype=np.uint32)
    body = Manifold(
        Mesh64(
            np.array(vertices),
            facets,
            run_index=runs[: 2 + bool(len(caps))],
            run_original_id=names[: 1 + bool(len(caps))],
        )
    )
    best, shares = surface, list(DEVIATIONS)
    while shares:
        share = shares.pop(0)
        mesh = body.simplify(share * surface.diameter).to_mesh64()
        triangles = _run(mesh, name)
        if not len(triangles):
            break
        used, index = np.unique(triangles, return_inverse=True)
        best = Surface(np.asarray(mesh.vert_properties, dtype=np.float64)[used, :3], index.reshape(-1, 3))
        if len(triangles) <= FEW:
            break
        shares += [2 * share] if not shares and len(triangles) > MANY and share < 0.1 else []
    return best, deviation(surface, best)


def _run(mesh: Any, name: int) -> Ints:  # noqa: ANN401 - manifold3d ships no types
    """The triangles (T, 3) that come from those of this name."""
    triangles = np.asarray(mesh.tri_verts, dtype=np.int64)
    bounds = [int(x) // 3 for x in mesh.run_index]
    parts = [triangles[a:b] for a, b, own in zip(bounds, bounds[1:], mesh.run_original_id, strict=False) if own == name]
    return np.concatenate(parts) if parts else triangles[:0]


def _by_quadrics(surface: Surface) -> tuple[Surface, float]:
    """With the fewest of a few numbers of triangles that is near enough."""
    best, best_off = surface, 0.0
    for number in np.linspace(FEW, MANY, 4).astype(int).tolist():
        fewer = _decimated(surface, number) if number < len(surface.triangles) else None
        if fewer is not None:
            best, best_off = fewer, deviation(surface, fewer)
            if best_off <= DEVIATIONS[-1] * surface.diameter:
                break
    return best, best_off


def _decimated(surface: Surface, number: int) -> Surface | None:
    """About ``number`` triangles; None where nothing is left."""
    import trimesh

    facets = np.array(surface.triangles, order="C")
    mesh: Any = trimesh.Trimesh((surface.vertices - surface.centre) / surface.diameter, facets, process=False)
    small = mesh.simplify_quadric_decimation(face_count=number, aggression=AGGRESSION)
    try:
        vertices = np.asarray(small.vertices, dtype=float) * surface.diameter + surface.centre
        rough = welded(vertices, np.asarray(small.faces, dtype=np.int64))
    except SurfaceError:
        return None
    return Surface(rough.vertices, turned_outward(rough.vertices, rough.triangles))


def deviation(surface: Surface, fewer: Surface) -> float:
    """The largest distance found between the two, m.

    From the one's vertices to the other's triangles, and back from points on it.
    """
    there = Nearness(fewer.vertices, fewer.triangles).distance(_some(surface.vertices))
    back = Nearness(surface.vertices, surface.triangles).distance(
        _some(spread(fewer.vertices, fewer.triangles, PROBES)[0])
    )
    return float(max(there.max(), back.max()))


def _some(points: Floats) -> Floats:
    return points[:: max(1, len(points) // PROBES)]
