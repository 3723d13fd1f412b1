"""How far apart two bodies are, and how far a body is from the camera or another place: metres between surfaces, 0 where bodies meet.

* ``Spread``: points spread over a surface, and balls round its facets, which tell the nearest place fast

The nearest place on triangles to a point.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.overlap import Solid
from geometry.frames import transform_points
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.rays import RayMesh

FEW = 20_000
"""Pairs of facets that are gone through one by one; of more, the nearest are found from points spread over both
surfaces."""
SPREAD = 500
"""Such points, and about as many corners at most."""
STEPS = 20
"""Times, at most, that the nearest place on the one is followed to the nearest on the other."""
SETTLED = 1e-3
"""Share of the gap by which a step must lessen it, or the next is not taken."""


class Spread(NamedTuple):
    """``points`` (N, 3) m, object frame, and their k-d tree.

    ``middles`` (T, 3) and ``radii`` (T,) of balls that hold the facets.
    """

    points: Floats
    tree: Any
    middles: Floats
    radii: Floats


def gap(x: PosedSurface, y: PosedSurface, solids: tuple[Solid | None, Solid | None] = (None, None)) -> float:
    """Metres between two posed surfaces, the least; 0 where their `solids`, if both are known, share volume or touch.

    Exact for two solids of few facets; else it may be larger, by no more than is between the points that are spread
    over a surface.
    """
    first, second = solids
    own_from_other = x.object_from_camera @ y.camera_from_object
    if first is not None and second is not None:
        if len(first.triangles) * len(second.triangles) <= FEW:
            between = float(np.linalg.norm(transform_points(own_from_other, second.centre[None])[0] - first.centre))
            return float(
                first.body.min_gap(second.body.transform(own_from_other[:3]), between + first.radius + second.radius)
            )
        if first.shared(own_from_other, second) > 0.0:
            return 0.0
    return _followed(x, y, own_from_other)


def distance(surface: PosedSurface, place_camera: Floats | None = None) -> float:
    """Metres from a place (3,), camera frame, or the camera's centre, to the nearest place of a posed surface."""
    place = np.zeros(3) if place_camera is None else place_camera
    eye = transform_points(surface.object_from_camera, place[None])[0]
    return float(np.linalg.norm(_nearest(surface, eye) - eye))


def _followed(x: PosedSurface, y: PosedSurface, x_from_y: Floats) -> float:
    """From the nearest two of the spread points on, by the nearest place on either surface in turn."""
    first, second = spread(x.rays), spread(y.rays)
    far, at = first.tree.query(transform_points(x_from_y, second.points))
    best, here = float(far.min()), first.points[at[far.argmin()]]
    y_from_x = y.object_from_camera @ x.camera_from_object
    for _ in range(STEPS):
        beyond = transform_points(x_from_y, _nearest(y, transform_points(y_from_x, here[None])[0])[None])[0]
        here = _nearest(x, beyond)
        before, best = best, min(best, float(np.linalg.norm(here - beyond)))
        if before - best <= SETTLED * best + SETTLED**2:
            break
    return best


def _nearest(surface: PosedSurface, place: Floats) -> Floats:
    """The place (3,) of a surface that is nearest to another, object frame: by the balls round its facets, then by the few that are left."""
    points = spread(surface.rays)
    far = np.linalg.norm(points.middles - place, axis=1)
    few = surface.vertices[surface.triangles[far - points.radii <= (far + points.radii).min()]]
    nearest = nearest_places(few, place)
    return np.asarray(nearest[np.linalg.norm(nearest - place, axis=1).argmin()])


@lru_cache(maxsize=256)
def spread(rays: RayMesh) -> Spread:
    """Of one surface, once; always the same points."""
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(0)
    corners = rays.vertices[rays.triangles]
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    some = rng.choice(len(area), SPREAD, p=area / area.sum()) if area.sum() > 0.0 else np.zeros(SPREAD, dtype=np.intp)
    u, v = np.sort(rng.random((2, SPREAD)), axis=0)[..., None]
    points = np.concatenate(
        [rays.vertices[:: 1 + len(rays.vertices) // SPREAD], u * a[some] + (v - u) * b[some] + (1.0 - v) * c[some]]
    )
    middles = corners.mean(axis=1)
    return Spread(points, cKDTree(points), middles, np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1))


def nearest_places(corners: Floats, place: Floats) -> Floats:
    """Of each triangle of `corners` (T, 3, 3) the place (T, 3) that is nearest to `place` (3,): in its inside, or on an edge."""
    sides = np.roll(corners, -1, axis=1) - corners
    length = (sides**2).sum(axis=2)
    share = np.clip(((place - corners) * sides).sum(axis=2) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    on_edges = corners + share[..., None] * sides
    best = ((on_edges - place) ** 2).sum(axis=2).argmin(axis=1)
    found = np.take_along_axis(on_edges, best[:, None, None], axis=1)[:, 0]
    normal = np.cross(sides[:, 0], sides[:, 1])
    area = (normal**2).sum(axis=1)
    foot = place - (((place - corners[:, 0]) * normal).sum(axis=1) / np.where(area > 0.0, area, 1.0))[:, None] * normal
    turns = (np.cross(sides, foot[:, None] - corners) * normal[:, None]).sum(axis=2)
    return np.where(((turns >= 0.0).all(axis=1) & (area > 0.0))[:, None], foot, found)
