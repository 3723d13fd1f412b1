"""A ball that fits into a body: its radius bounds the body's thickness from below, however dented it is."""

from typing import Any

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.nearest import nearest_places
from geometry.visibility.rays import RayMesh

TRIED = 200
"""Facets from whose middles a chord is drawn into the body; its own middle is where a ball is tried."""


def inscribed_radius(body: Any) -> float:  # noqa: ANN401 - manifold3d ships no types
    """Radius, m, of the largest of some balls inside a body of manifold3d: each about the middle of a chord at right angles to a large facet."""
    mesh = body.to_mesh64()
    vertices, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    large = np.argsort(-area, kind="stable")[:TRIED]
    large = large[area[large] > 0.0]
    if not len(large):
        return 0.0
    inward = -normals[large] / area[large, None]
    starts = corners[large].mean(axis=1)
    rays = RayMesh(vertices, triangles)
    chords = rays.first_hit(
        starts + 1e-6 * rays.size * inward, inward
    )  # a little inside, so that the facet itself is not met
    kept = np.isfinite(chords)
    middles, best = starts[kept] + 0.5 * chords[kept, None] * inward[kept], 0.0
    balls = corners.mean(axis=1), np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    for place in np.argsort(-chords[kept], kind="stable"):
        if 0.5 * chords[kept][place] > best:
            best = max(best, _distance(corners, balls, middles[place]))
    return best


def _distance(corners: Floats, balls: tuple[Floats, Floats], place: Floats) -> float:
    """Metres from a place (3,) to the nearest of triangles (T, 3, 3); `balls`, middles (T, 3) and radii (T,), hold these, so that few are asked."""
    far = np.linalg.norm(balls[0] - place, axis=1)
    few = corners[far - balls[1] <= (far + balls[1]).min()]
    return float(np.linalg.norm(nearest_places(few, place) - place, axis=1).min())
