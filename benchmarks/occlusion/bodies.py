"""Bodies for ``plogic bench occlusion``: convex and concave prisms, and the solids of stacks.

Each a closed, outward surface.

``Body(vertices, triangles, rays, solid)``: made once, posed at will.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import shapely

from geometry.bodies.overlap import Solid
from geometry.camera import Camera
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.rays import RayMesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]

CAMERA = Camera(640, 480, np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]))
_FACES = (
    ((-1, 0, 0), ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0))),
    ((1, 0, 0), ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1))),
    ((0, -1, 0), ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1))),
    ((0, 1, 0), ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0))),
    ((0, 0, -1), ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0))),
    ((0, 0, 1), ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))),
)
"""Of a block: the neighbour that a side faces, and the side's corners, counterclockwise from outside."""


class Body(NamedTuple):
    """A closed surface: ``vertices`` (V, 3) m, ``triangles`` (T, 3), ready to be shot at and to be overlapped."""

    vertices: Floats
    triangles: Ints
    rays: RayMesh
    solid: Solid


def body(vertices: Floats, triangles: Ints) -> Body:
    """The body of a surface."""
    return Body(vertices, triangles, RayMesh(vertices, triangles), Solid(vertices, triangles))


def posed(one: Body, camera_from_object: Floats) -> PosedSurface:
    """The body where it stands."""
    return PosedSurface(one.vertices, one.triangles, one.rays, camera_from_object)


def placed(vertices: Floats, triangles: Ints) -> PosedSurface:
    """A surface that is in the camera's frame already."""
    return PosedSurface(vertices, triangles, RayMesh(vertices, triangles), np.eye(4))


def convex_bodies() -> list[Body]:
    """Boxes, a wedge, a prism of six sides, a pyramid."""
    six = [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]
    apex = np.array([[-0.4, -0.4, 0.0], [0.4, -0.4, 0.0], [0.4, 0.4, 0.0], [-0.4, 0.4, 0.0], [0.0, 0.0, 0.9]])
    sides = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    rings = [
        shapely.box(-0.4, -0.3, 0.4, 0.3),
        shapely.box(-0.7, -0.7, 0.7, 0.7),
        shapely.Polygon([(0, 0), (0.9, 0), (0, 0.6)]),
    ]
    return [prism(ring, high) for ring, high in zip(rings, (1.1, 0.2, 0.5), strict=True)] + [
        prism(shapely.Polygon([(0.4 * x, 0.4 * y) for x, y in six]), 0.7),
        body(apex, sides),
    ]


def concave_bodies() -> list[Body]:
    """L, U, a hook, a ring, a cross."""
    square = shapely.box(-0.7, -0.7, 0.7, 0.7)
    ring = square.difference(shapely.box(-0.4, -0.4, 0.4, 0.4))
    hook = ring.difference(shapely.box(-0.1, -0.8, 0.8, -0.2))
    cross = shapely.box(-0.7, -0.2, 0.7, 0.2).union(shapely.box(-0.2, -0.7, 0.2, 0.7))
    u = square.difference(shapely.box(-0.35, -0.3, 0.35, 0.8))
    ell = square.difference(shapely.box(-0.3, -0.3, 0.8, 0.8))
    return [prism(shape, 0.4) for shape in (ell, u, hook, ring, cross)]


def prism(shape: Any, height: float) -> Body:  # noqa: ANN401 - shapely ships no types
    """The prism over a polygon of shapely's, holes and all, from z = 0 to ``height``."""
    rings = [shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(shapely.orient_polygons(shape))]
    corners = np.concatenate(rings)
    index = {tuple(point): i for i, point in enumerate(corners.tolist())}
    count = len(corners)
    facets: list[tuple[int, int, int]] = []
    for triangle in shapely.constrained_delaunay_triangles(shape).geoms:
        a, b, c = (
            index[tuple(point)] for point in shapely.get_coordinates(shapely.orient_polygons(triangle))[:3].tolist()
        )
        facets += [(c, b, a), (a + count, b + count, c + count)]
    for ring in rings:
        here = [index[tuple(point)] for point in ring.tolist()]
        for a, b in zip(here, here[1:] + here[:1], strict=True):
            facets += [(a, b, b + count), (a, b + count, a + count)]
    low = np.c_[corners, np.zeros(count)]
    return body(np.vstack([low, low + np.array([0.0, 0.0, height])]), np.array(facets))


def stack_surface(blocks: NDArray[np.bool_], across: Floats, down: Floats, depth: Floats) -> PosedSurface:
    """The surface of a stack's body (U, V, L), camera frame.

    The grid's lines in pixels (U + 1,), (V + 1,), its layers' ends in m (L + 1,).
    """
    padded = np.pad(blocks, 1)
    quads = []
    for step, corners in _FACES:
        bare = blocks & ~np.roll(padded, tuple(-s for s in step), axis=(0, 1, 2))[1:-1, 1:-1, 1:-1]
        quads.append(np.argwhere(bare)[:, None, :] + np.array(corners)[None])
    nodes, index = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    four = index.reshape(-1, 4)
    ideal = CAMERA.from_pixels(np.stack([across[nodes[:, 0]], down[nodes[:, 1]]], axis=-1))
    vertices = np.c_[ideal, np.ones(len(nodes))] * depth[nodes[:, 2], None]
    return placed(vertices, np.concatenate([four[:, [0, 1, 2]], four[:, [0, 2, 3]]]))
