"""The outline of a posed surface on the image: the exact union of its projected triangles, in pixels.

It is taken in ideal pixels (no distortion), where edges are straight, and then bent along the lens where there is one.

The exact union of the images of many triangles, by their contour: a surface of thousands of triangles has a contour of
hundreds of edges.

Turned the same way round, neighbours run along a common edge in opposite ways, which cancel: what is left is the
contour. How often the contour winds about a point is how many triangles cover it. So the contour, cut where it crosses
itself, parts the plane into faces that are covered wholly or not at all, and those covered are the union.
"""

from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Ints, Mask, last_axes
from geometry.camera import Camera, distort, fold_radius
from geometry.frames import transform_points

Shapes = Any  # a geometry of shapely's, or an array of them: shapely ships no types

_SLIT = 1e-6  # px; what is nearer to an edge may be on either side of it


Area = Any  # a shapely Polygon, MultiPolygon, or an empty geometry: shapely ships no types

NEAR = 1e-3  # m; what is nearer than this is cut off
_EDGE = 4.0  # px between the points of an edge that a lens bends
_SLIVER = 1e-9  # px^2; triangles seen edge-on to within this have no image
_FEW = 50  # triangles: so many are sooner put together one by one than by their contour


def outline(vertices: ArrayLike, triangles: ArrayLike, camera_from_object: ArrayLike, camera: Camera) -> Area:
    """The image, in pixels, of the surface `vertices` (V, 3) m, `triangles` (T, 3), posed by `camera_from_object`.

    Not clipped to the image. Empty where nothing is farther than 1 mm in front of the camera.
    """
    return bent(ideal_outline(vertices, triangles, camera_from_object, camera), camera)


def ideal_outline(vertices: ArrayLike, triangles: ArrayLike, camera_from_object: ArrayLike, camera: Camera) -> Area:
    """As `outline`, in ideal pixels: what the same camera would show without distortion."""
    placed = transform_points(camera_from_object, last_axes(vertices, (-1, 3), "vertices"))
    facets = np.asarray(triangles, dtype=np.int64)
    if (placed[:, 2] >= NEAR).all():
        return drawn_together(camera.to_pixels(placed[:, :2] / placed[:, 2:]), facets)
    pieces = [piece for piece in (_clipped(corners) for corners in placed[facets]) if len(piece) >= 3]
    return shapely.union_all([shapely.Polygon(camera.to_pixels(p[:, :2] / p[:, 2:])) for p in pieces])


def bent(area: Area, camera: Camera) -> Area:
    """The `area` of ideal pixels as the lens shows it; what lies past the lens' fold is cut off."""
    if not np.any(camera.dist) or area.is_empty:
        return area
    edge = fold_radius(camera.dist)
    if np.isfinite(edge):
        angles = np.linspace(0, 2 * np.pi, 256, endpoint=False)
        ring = 0.999 * edge * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        area = area.intersection(shapely.Polygon(camera.to_pixels(ring)))
    fine = shapely.segmentize(area, max(_EDGE, shapely.length(area) / 10_000))
    shown = shapely.transform(fine, lambda uv: camera.to_pixels(distort(camera.from_pixels(uv), camera.dist)))
    return shown if shown.is_valid else shapely.make_valid(shown)


def image_area(camera: Camera) -> Area:
    """The image itself, [-0.5, width - 0.5] x [-0.5, height - 0.5] px."""
    return shapely.box(-0.5, -0.5, camera.width - 0.5, camera.height - 0.5)


def is_closed(triangles: Ints) -> bool:
    """Whether each edge of `triangles` (T, 3) is run as often one way as the other: a closed, oriented surface."""
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    span = int(triangles.max(initial=0)) + 1
    return bool(np.array_equal(np.sort(starts * span + ends), np.sort(ends * span + starts)))


def turning(corners: Floats) -> Floats:
    """Twice the signed area (T,) of the triangles `corners` (T, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def facing(corners: Floats, triangles: Ints) -> Mask:
    """Which triangles (T,) make the outline: a line of sight through a closed surface meets both sides, so one does.

    The side with fewer triangles is taken; without a closed surface, every triangle that is not seen edge-on.
    """
    sense = turning(corners)
    front, back = sense > _SLIVER, sense < -_SLIVER
    if not is_closed(triangles):
        return np.asarray(front | back)
    return np.asarray(front if front.sum() <= back.sum() else back)


def drawn_together(pixels: Floats, triangles: Ints) -> Area:
    """The union of the images of `triangles` (T, 3) with corners at `pixels` (V, 2), or at other places of a plane."""
    corners = pixels[triangles]
    facets = facing(corners, triangles)
    if facets.sum() <= _FEW:
        return shapely.union_all(shapely.polygons(corners[facets]))
    return union_by_contour(pixels, triangles[facets])


def _clipped(corners: Floats) -> Floats:
    """The part (K, 3) of the triangle `corners` (3, 3) at z >= NEAR: three or four corners, or none."""
    kept: list[Floats] = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside, next_inside = here[2] >= NEAR, there[2] >= NEAR
        if inside:
            kept.append(here)
        if inside != next_inside:
            crossing = here + (there - here) * ((NEAR - here[2]) / (there[2] - here[2]))
            kept.append(np.array([crossing[0], crossing[1], NEAR]))
    return np.array(kept).reshape(-1, 3)


def contour(pixels: Floats, triangles: Ints) -> Ints:
    """(E, 2) the directed edges of `triangles` (T, 3) that remain where those of neighbours cancel.

    They index `pixels` (V, 2).

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
    """(N,) winding numbers about `points` (N, 2), none on an edge, of closed lines of directed edges.

    The edges lead from `starts` (E, 2) to `ends` (E, 2).

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
    """The area that `triangles` (T, 3) with corners `pixels` (V, 2) cover: a shapely Polygon or MultiPolygon.

    Empty without triangles.
    """
    edges = contour(pixels, triangles)
    drawn = np.unique(np.sort(edges, axis=1), axis=0)
    lines = shapely.union_all(shapely.linestrings(pixels[drawn]))
    faces = shapely.get_parts(shapely.polygonize([lines]))
    inside = _inside(faces, lines)
    covered = winding(inside, pixels[edges[:, 0]], pixels[edges[:, 1]]) != 0
    return shapely.coverage_union_all(faces[covered | (shapely.area(faces) < _SLIVER)])


def _inside(faces: Shapes, lines: Shapes) -> Floats:
    """(N, 2) a point in each of N faces that lies on none of the `lines`.

    A slit, two edges that agree but for rounding, parts no face.
    """
    points = shapely.point_on_surface(faces)
    shapely.prepare(lines)
    near = np.flatnonzero(shapely.dwithin(lines, points, _SLIT))
    around = shapely.bounds(faces[near]) + np.array([-2.0, -2.0, 2.0, 2.0]) * _SLIT
    for i, box in zip(near, around, strict=True):
        slit = shapely.buffer(shapely.clip_by_rect(lines, *box), _SLIT)  # of all lines it takes a tenth of a second
        parts = shapely.get_parts(shapely.difference(faces[i], slit))
        sizes = shapely.area(parts)
        if sizes.max(initial=0.0) > 0.0:  # else the face is a slit itself
            points[i] = shapely.point_on_surface(parts[sizes.argmax()])
    return shapely.get_coordinates(points)
