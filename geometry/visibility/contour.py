"""The exact union of the images of many triangles, by their contour: a surface of thousands of triangles has a contour of hundreds of edges.

Turned the same way round, neighbours run along a common edge in opposite ways, which cancel: what is left is the
contour. How often the contour winds about a point is how many triangles cover it. So the contour, cut where it crosses
itself, parts the plane into faces that are covered wholly or not at all, and those covered are the union.
"""

from typing import Any

import numpy as np
import shapely

from geometry.arrays import Floats, Ints

Shapes = Any  # a geometry of shapely's, or an array of them: shapely ships no types

_SLIVER = 1e-9  # px^2; a face that is smaller is a crack between neighbours, by rounding
_SLIT = 1e-6  # px; what is nearer to an edge may be on either side of it


def contour(pixels: Floats, triangles: Ints) -> Ints:
    """(E, 2) directed edges, by index into `pixels` (V, 2), that are left of the edges of `triangles` (T, 3) where those of neighbours cancel.

    Wound all one way; an edge that k triangles run along one way and none the other is there k times.
    """
    a, b = (pixels[triangles[:, i]] - pixels[triangles[:, 0]] for i in (1, 2))
    turned = np.where((a[:, 0] * b[:, 1] < a[:, 1] * b[:, 0])[:, None], triangles[:, ::-1], triangles)
    starts, ends = turned.ravel(), np.roll(turned, -1, axis=1).ravel()
    span = len(pixels)
    edges, which = np.unique(np.minimum(starts, ends) * span + np.maximum(starts, ends), return_inverse=True)
    net = np.bincount(which, np.where(starts < ends, 1, -1), len(edges)).astype(int)
    both = np.repeat(np.stack([edges // span, edges % span], axis=1), np.abs(net), axis=0)
    return np.where(np.repeat(net, np.abs(net))[:, None] > 0, both, both[:, ::-1])


def winding(points: Floats, starts: Floats, ends: Floats) -> Ints:
    """(N,) how often the closed lines of directed edges from `starts` (E, 2) to `ends` (E, 2) wind about `points` (N, 2), none on an edge.

    Counted along the ray to greater x; each edge is asked only of the points at its height.
    """
    order = np.argsort(points[:, 1], kind="stable")
    heights = points[order, 1]
    low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
    first, count = np.searchsorted(heights, low), np.searchsorted(heights, high)
    count -= first
    edge = np.repeat(np.arange(len(starts)), count)
    point = order[np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)]
    along, to = (ends - starts)[edge], points[point] - starts[edge]
    side = np.sign(along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0])
    crossed = side == np.sign(along[:, 1])
    return np.bincount(point[crossed], side[crossed], len(points)).astype(int)


def union_by_contour(pixels: Floats, triangles: Ints) -> Shapes:
    """The area that `triangles` (T, 3) with corners `pixels` (V, 2) cover: a shapely Polygon or MultiPolygon; empty without triangles."""
    edges = contour(pixels, triangles)
    drawn = np.unique(np.sort(edges, axis=1), axis=0)
    lines = shapely.union_all(shapely.linestrings(pixels[drawn]))
    faces = shapely.get_parts(shapely.polygonize([lines]))
    inside = _inside(faces, lines)
    covered = winding(inside, pixels[edges[:, 0]], pixels[edges[:, 1]]) != 0
    return shapely.coverage_union_all(faces[covered | (shapely.area(faces) < _SLIVER)])


def _inside(faces: Shapes, lines: Shapes) -> Floats:
    """(N, 2) a point in each of N faces that lies on none of the `lines`: a slit, two edges that agree but for rounding, parts no face."""
    points = shapely.point_on_surface(faces)
    near = np.flatnonzero(shapely.distance(points, lines) < _SLIT)
    slit = shapely.buffer(lines, _SLIT) if len(near) else None
    for i in near:
        parts = shapely.get_parts(shapely.difference(faces[i], slit))
        sizes = shapely.area(parts)
        if sizes.max(initial=0.0) > 0.0:  # else the face is a slit itself
            points[i] = shapely.point_on_surface(parts[sizes.argmax()])
    return shapely.get_coordinates(points)
