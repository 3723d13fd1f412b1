"""Putting things down on a table: a side of chance below, close together but apart, then physics brings them to rest."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.settle import settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

UPRIGHT = 0.6
"""Share of the things that stand as their mesh does; the others lie on a side of chance."""
GAP = 0.006
"""Metres between two footprints before the physics."""
TRIES = 40
GRAIN = 0.002
"""Metres that a hull may miss: one of thousands of corners takes long and is no better."""
FLOATING = 0.006


def put_down(
    things: Sequence[tuple[str | None, TexturedMesh]], rng: np.random.Generator, spread: float
) -> tuple[Body, ...] | None:
    """The things at rest around the origin, ``spread`` metres and more about it; None where there is no room or no rest."""
    placed: list[Body] = []
    for label, mesh in things:
        body = _beside(placed, label, mesh, rng, spread)
        if body is None:
            return None
        placed.append(body)
    proxies = [replace(body, mesh=hull(body.mesh)) for body in placed]
    try:
        rested = settle(proxies, int(rng.integers(2**31)), drop=0.004)
    except SceneError:
        return None
    return tuple(
        _grounded(replace(body, world_from_body=r.world_from_body)) for body, r in zip(placed, rested, strict=True)
    )


def hull(mesh: TexturedMesh) -> TexturedMesh:
    """The convex hull, of corners at least 2 mm apart: what the physics takes the thing for, concave or not."""
    from scipy.spatial import ConvexHull

    points = np.unique(np.round(mesh.vertices[ConvexHull(mesh.vertices).vertices] / GRAIN), axis=0) * GRAIN
    corners = points[ConvexHull(points).vertices]
    return TexturedMesh(corners, ConvexHull(corners).simplices)


def _beside(
    placed: Sequence[Body], label: str | None, mesh: TexturedMesh, rng: np.random.Generator, spread: float
) -> Body | None:
    """The mesh at a place where its footprint is free; the circle around the origin grows with every try."""
    from shapely import MultiPoint

    prints = [MultiPoint(b.vertices_world[:, :2]).convex_hull for b in placed]
    for i in range(TRIES):
        reach = spread * (0.5 + i / TRIES)
        pose = _standing(mesh, rng, rng.uniform(-reach, reach, 2))
        body = Body(label, mesh, pose)
        own = MultiPoint(body.vertices_world[:, :2]).convex_hull
        if all(own.distance(other) > GAP for other in prints):
            return body
    return None


def _standing(mesh: TexturedMesh, rng: np.random.Generator, at: NDArray[np.float64]) -> NDArray[np.float64]:
    """World pose with one of the six sides below, turned about the vertical by chance, its box's middle over ``at`` (2,)."""
    from scipy.spatial.transform import Rotation

    down = Rotation.identity()
    if rng.random() > UPRIGHT:
        axis, turns = ("x", (90, 180, 270)) if rng.random() < 0.6 else ("y", (90, 270))
        down = Rotation.from_euler(axis, float(rng.choice(turns)), degrees=True)
    pose = np.eye(4)
    pose[:3, :3] = (Rotation.from_euler("z", rng.uniform(0, 360), degrees=True) * down).as_matrix()
    points = mesh.vertices @ pose[:3, :3].T
    low, high = points.min(axis=0), points.max(axis=0)
    pose[:3, 3] = (*(at - (low + high)[:2] / 2), -low[2])
    return pose


def _grounded(body: Body) -> Body:
    """Set on the floor what the physics' margins left a little above or below it."""
    lowest = float(body.vertices_world[:, 2].min())
    if abs(lowest) > FLOATING:
        return body
    pose = body.world_from_body.copy()
    pose[2, 3] -= lowest
    return replace(body, world_from_body=pose)
