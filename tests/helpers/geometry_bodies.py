"""Bodies and poses that the geometry tests share, each with its closed, outward surface."""

import numpy as np

from geometry.camera import Camera
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.rays import RayMesh

CAMERA = Camera(640, 480, np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]]))
LENS = Camera(
    640, 480, np.array([[600.0, 0, 320], [0, 590, 240], [0, 0, 1]]), np.array([-0.25, 0.08, 1e-3, -2e-3, 0.01])
)


def prism(ring, height):
    """The prism over the counter-clockwise `ring` (N, 2), from z = 0 to `height`; its caps are cut into ears."""
    import shapely

    n = len(ring)
    low, high = np.c_[ring, np.zeros(n)], np.c_[ring, np.full(n, height)]
    corners = {tuple(point): index for index, point in enumerate(map(tuple, np.asarray(ring, dtype=float)))}
    facets = []
    for triangle in shapely.constrained_delaunay_triangles(shapely.Polygon(ring)).geoms:
        outer = shapely.get_coordinates(shapely.orient_polygons(triangle))[:3]
        a, b, c = (corners[tuple(point)] for point in outer)
        facets += [(c, b, a), (a + n, b + n, c + n)]
    for i in range(n):
        j = (i + 1) % n
        facets += [(i, j, j + n), (i, j + n, i + n)]
    return np.vstack([low, high]), np.array(facets)


def box(x=1.0, y=1.0, z=1.0):
    return prism([(-x / 2, -y / 2), (x / 2, -y / 2), (x / 2, y / 2), (-x / 2, y / 2)], z)


def wedge():
    """T1-like: a base 0.8 x 0.6, 1.1 m high on one side and 1.5 m on the other."""
    vertices, triangles = box(0.8, 0.6, 1.1)
    vertices = vertices.copy()
    vertices[[5, 6], 2] = 1.5
    return vertices, triangles


def bracket():
    """A U seen from above: concave, so bodies can stand within it."""
    return prism([(-1, -0.6), (1, -0.6), (1, 0.6), (0.6, 0.6), (0.6, -0.2), (-0.6, -0.2), (-0.6, 0.6), (-1, 0.6)], 0.8)


def bodies():
    return [box(0.8, 0.6, 1.2), wedge(), bracket()]


def random_rotations(rng, count):
    return rotation_from_quat_xyzw(rng.normal(size=(count, 4)))


def at(x=0.0, y=0.0, z=0.0, R=None):
    return from_rotation_translation(np.eye(3) if R is None else R, [x, y, z])


def posed(body, camera_from_object):
    return PosedSurface(*body, RayMesh(*body), camera_from_object)
