"""The occlusion relation of a posed pair, by exact outlines and depth (§3.5-3.7).

ROC-20, and the six coarse ones that it refines.

The outlines decide how the images lie to each other (RCC-8, below); the first surface that a line of
sight meets decides who is in front on the common interior; ``geometry.visibility.roc`` names the twenty. Exactly one
holds of any pair at the stated tolerance, and R(x, y) is the converse of R(y, x), bit for bit: the two are taken in an
order that does not depend on which came first. Where the images share an interior and neither is first anywhere
(coincident surfaces), each is there at once with the other, and the relation is mutual.

RCC-8 of two areas of the image at a tolerance (§3.7): which of the eight ways two images can lie to each other.

| relation    | of a to b, at the tolerance t px                                                                    |
|-------------|-----------------------------------------------------------------------------------------------------|
| DC          | no common interior, and farther than t from each other                                              |
| EC          | no common interior, and t or less from each other                                                   |
| PO          | a common interior, and each sticks out of the other                                                 |
| TPP, NTPP   | a common interior, a is covered and b sticks out; boundaries come as near as t (TPP), or not (NTPP) |
| TPPi, NTPPi | the converses                                                                                       |
| EQ          | a common interior, and each is covered by the other                                                 |

The common interior is what is left of the intersection less a seam of t: what is thinner than 2 t is none. Of two areas
one is covered by the other if no point of it is farther than t from the other. Read from the top each row says what the
rows before it leave open, so exactly one relation holds; each row is the mirror of its converse's, and the areas are
taken in an order of their own, so that R(a, b) is the converse of R(b, a), bit for bit. An area without points is DC
from everything.

How much of a posed surface is seen: the part of its image in front of which nothing stands.

Where to ask which of two surfaces is in front: an even grid, then sure points.

Within the image of one facet of x crossed with one facet of y the difference of the inverse depths is linear, so it
takes its extremes at the corners: points just inside the corners of every such crossing, and its middle, miss no change
of order between facets that are seen. The grid settles most of what is mutual without them; both are deterministic.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from geometry.arrays import Floats, Ints, frozen
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid, rotate, transform_points
from geometry.visibility.outline import NEAR, Area, ideal_outline, is_closed, outline
from geometry.visibility.rays import RayMesh
from geometry.visibility.roc import Front, Rcc8, Roc, rcc_converse, roc

_QUARTER = 16  # corners of a quarter of a circle: a widened area falls short of its tolerance by 0.1 % of it at most

_CRACK = 1e-6  # px; an area's boundary that runs to and fro within so much is there by rounding


TOLERANCE = 0.25  # px: what of an image is thinner than twice this is no interior, what sticks out less is covered, what is nearer touches
DEPTH_TOLERANCE = 1e-4  # of the distance: surfaces nearer to each other than this along a ray are equally near


@dataclass(frozen=True, eq=False)
class PosedSurface:
    """A surface where it stands: `vertices` (V, 3) m, `triangles` (T, 3), its `rays`, and its pose (4, 4)."""

    vertices: Floats
    triangles: Ints
    rays: RayMesh
    camera_from_object: Floats

    def __post_init__(self) -> None:
        """Keep a read-only pose, a rigid one."""
        if not is_rigid(self.camera_from_object):
            raise GeometryError(f"camera_from_object must be rigid, not {np.asarray(self.camera_from_object).tolist()}")
        object.__setattr__(self, "camera_from_object", frozen(self.camera_from_object))

    @cached_property
    def object_from_camera(self) -> Floats:
        """The inverse pose (4, 4)."""
        return frozen(inverse(self.camera_from_object))

    @cached_property
    def reach(self) -> tuple[float, float]:
        """Least and greatest z (m, camera frame) of the surface."""
        z = transform_points(self.camera_from_object, self.vertices)[:, 2]
        return float(z.min()), float(z.max())

    def depth(self, rays_camera: Floats) -> Floats:
        """Distance (N,) m from the camera's centre along `rays_camera` (N, 3) to the surface; inf for none."""
        ahead = rotate(self.object_from_camera, rays_camera)
        return self.rays.first_hit(np.broadcast_to(self.object_from_camera[:3, 3], ahead.shape), ahead)


def occlusion(
    x: PosedSurface,
    y: PosedSurface,
    camera: Camera,
    tolerance: float = TOLERANCE,
    *,
    depth_tolerance: float = DEPTH_TOLERANCE,
    images: tuple[Area, Area] | None = None,
) -> Roc:
    """The one relation of ROC-20 that holds of x and y as `camera` sees them: 'partially_occludes_po' has x before y.

    `tolerance` (px) is that of the images; `depth_tolerance` (part of the distance)
    says when two are equally near. Decided on ideal pixels: the relation is topological, so a lens does not change it.
    Give the `images` of both (`drawn`) where they are known.
    """
    image_x, image_y = images or (drawn(x, camera), drawn(y, camera))
    rcc, interior = related(image_x, image_y, tolerance)
    return roc(rcc, "nobody" if interior.is_empty else _in_front(x, y, interior, camera, depth_tolerance))


def drawn(surface: PosedSurface, camera: Camera) -> Area:
    """The outline in ideal pixels."""
    return ideal_outline(surface.vertices, surface.triangles, surface.camera_from_object, camera)


def _in_front(x: PosedSurface, y: PosedSurface, interior: Area, camera: Camera, depth_tolerance: float) -> Front:
    """Who is first somewhere on the common `interior`; both, where neither is first anywhere."""
    swap = _key(y) < _key(x)
    a_first, b_first = _first((y, x) if swap else (x, y), interior, camera, depth_tolerance)
    if a_first == b_first:
        return "both"
    return "x" if a_first != swap else "y"


def _key(surface: PosedSurface) -> tuple[bytes, ...]:
    """What puts two surfaces into an order of their own."""
    return surface.camera_from_object.tobytes(), surface.vertices.tobytes(), surface.triangles.tobytes()


def _first(
    pair: tuple[PosedSurface, PosedSurface], interior: Area, camera: Camera, depth_tolerance: float
) -> tuple[bool, bool]:
    """Whether each of the two is the first that some line of sight through the common `interior` meets.

    Where the one ends before the other begins no ray is needed: along a ray the distance grows with z.
    """
    a, b = pair
    if min(a.reach[0], b.reach[0]) >= NEAR:
        if a.reach[1] < b.reach[0] * (1 - depth_tolerance):
            return True, False
        if b.reach[1] < a.reach[0] * (1 - depth_tolerance):
            return False, True
    a_first = b_first = False
    for pixels in samples_inside(interior, pair, camera):
        ideal = camera.from_pixels(pixels)
        rays = np.concatenate([ideal, np.ones((len(ideal), 1))], axis=-1)
        depth_a, depth_b = a.depth(rays), b.depth(rays)
        both = np.isfinite(depth_a) & np.isfinite(depth_b)
        gap, margin = depth_a[both] - depth_b[both], depth_tolerance * np.minimum(depth_a[both], depth_b[both])
        a_first, b_first = a_first or bool((gap < -margin).any()), b_first or bool((gap > margin).any())
        if a_first and b_first:
            break
    return a_first, b_first


class Related(NamedTuple):
    """How two areas lie to each other, and the ``interior`` that they share: empty for DC and EC."""

    rcc: Rcc8
    interior: Area


def related(a: Area, b: Area, tolerance: float) -> Related:
    """Return the RCC-8 relation of ``a`` to ``b`` at the ``tolerance`` (px), and their common interior less a seam."""
    if a.is_empty or b.is_empty or _boxes_gap(a, b) > tolerance:
        return Related("DC", shapely.Polygon())
    with np.errstate(
        divide="ignore", invalid="ignore"
    ):  # GEOS divides by the turn of edges that run on straight, and copes
        if b.wkb < a.wkb:
            found = _related(b, a, tolerance)
            return Related(rcc_converse(found.rcc), found.interior)
        return _related(a, b, tolerance)


def _related(a: Area, b: Area, tolerance: float) -> Related:
    common = shapely.intersection(a, b).buffer(-tolerance, join_style="mitre")
    if common.is_empty:
        return Related("EC" if shapely.dwithin(a, b, tolerance) else "DC", common)
    return Related(_of_overlapping(a, b, tolerance), common)


def _of_overlapping(a: Area, b: Area, tolerance: float) -> Rcc8:
    a_covered, b_covered = _covers(b, a, tolerance), _covers(a, b, tolerance)
    if a_covered == b_covered:
        return "EQ" if a_covered else "PO"
    if a_covered:
        return "TPP" if _tangential(a, b, tolerance) else "NTPP"
    return "TPPi" if _tangential(b, a, tolerance) else "NTPPi"


def _tangential(inner: Area, outer: Area, tolerance: float) -> bool:
    """Whether the boundaries come as near as ``tolerance``.

    A crack in ``outer``, where facets meet but for rounding, is no boundary.
    """
    if not shapely.dwithin(inner.boundary, outer.boundary, tolerance):
        return False
    return tolerance <= _CRACK or not outer.buffer(_CRACK).covers(inner.buffer(tolerance, quad_segs=_QUARTER))


def _covers(a: Area, b: Area, tolerance: float) -> bool:
    """Whether no point of ``b`` is farther than ``tolerance`` px from ``a``; cheap answers first."""
    (left_a, top_a, right_a, bottom_a), (left_b, top_b, right_b, bottom_b) = a.bounds, b.bounds
    if max(left_a - left_b, top_a - top_b, right_b - right_a, bottom_b - bottom_a) > tolerance:
        return False
    if a.covers(b):
        return True
    corners = shapely.points(shapely.get_coordinates(b))
    return bool(shapely.dwithin(corners, a, tolerance).all() and a.buffer(tolerance, quad_segs=_QUARTER).covers(b))


def _boxes_gap(a: Area, b: Area) -> float:
    """How far the boxes round the two are from each other along x or y, px; below 0 where they overlap."""
    (left_a, top_a, right_a, bottom_a), (left_b, top_b, right_b, bottom_b) = a.bounds, b.bounds
    return float(max(left_a - right_b, left_b - right_a, top_a - bottom_b, top_b - bottom_a))


def visible_fraction(surface: PosedSurface, others: Sequence[PosedSurface], camera: Camera, count: int = 2000) -> float:
    """The part in [0, 1] of the surface's whole image that lies in the picture and in front of all `others`.

    Taken on an even grid of about `count` points over the image in pixels; 0.0 for a surface without an image.
    """
    area = outline(surface.vertices, surface.triangles, surface.camera_from_object, camera)
    if area.is_empty or area.area == 0:
        return 0.0
    uv = even_grid(area, count)
    rays = camera.rays(uv)
    own = surface.depth(rays)
    hit = np.isfinite(own)
    seen = hit & camera.contains(uv)
    for other in others:
        seen &= ~(other.depth(rays) < own)
    return float(seen.sum() / hit.sum()) if hit.any() else 0.0


GRID = 400  # points, about, of the even grid over the common interior
CROSSINGS = 4000  # pairs of facets beyond which the crossings are thinned out evenly
_THIN = 0.02  # px; a crossing narrower than twice this is left out: along an edge of both surfaces single precision decides who is met
_INWARD = 0.02  # how far a corner's point is drawn towards the crossing's middle, as a part of the way


def samples_inside(common: Area, pair: tuple[PosedSurface, PosedSurface], camera: Camera) -> Iterator[Floats]:
    """Ideal pixels (N, 2) inside the `common` interior of the two images.

    First come the even ones, then the sure ones, which cost more.
    At least one for an interior not empty.
    """
    shapely.prepare(common)
    yield np.concatenate(
        [shapely.get_coordinates(shapely.point_on_surface(shapely.get_parts(common))), even_grid(common, GRID)]
    )
    yield _inside(common, _corners(_crossings(common, pair, camera)))


def _inside(area: Area, points: Floats) -> Floats:
    return np.asarray(points[shapely.contains_xy(area, points[:, 0], points[:, 1])])


def even_grid(area: Area, count: int) -> Floats:
    """About `count` pixels (N, 2) spread evenly over the box of `area`'s bounds and lying inside `area`."""
    left, top, right, bottom = area.bounds
    step = max(np.sqrt(max(area.area, 1e-12) / count), (right - left) / count, (bottom - top) / count, 1e-9)
    across, down = (np.arange(low + step / 2, high, step) for low, high in ((left, right), (top, bottom)))
    return _inside(area, np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2))


def _crossings(common: Area, pair: tuple[PosedSurface, PosedSurface], camera: Camera) -> Area:
    """The crossings (K,) of the images of facets of the one with facets of the other, within the bounds of `common`."""
    first, second = (_facets(surface, common, camera) for surface in pair)
    left, right = shapely.STRtree(second).query(first, predicate="intersects")
    every = max(1, -(-len(left) // CROSSINGS))
    return shapely.intersection(first[left[::every]], second[right[::every]])


def _facets(surface: PosedSurface, common: Area, camera: Camera) -> Area:
    """Images (K,) of the facets that may be seen in the bounds of `common`; none that crosses the near plane."""
    placed = transform_points(surface.camera_from_object, surface.vertices)
    corners = placed[surface.triangles]
    corners = corners[(corners[..., 2] >= NEAR).all(axis=1)]
    if is_closed(surface.triangles):  # of a closed, outward surface only what turns towards the camera is seen
        corners = corners[
            np.einsum("ti,ti->t", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0])
            < 0
        ]
    pixels = camera.to_pixels(corners[..., :2] / corners[..., 2:])
    left, top, right, bottom = common.bounds
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    near = (low[:, 0] <= right) & (high[:, 0] >= left) & (low[:, 1] <= bottom) & (high[:, 1] >= top)
    return shapely.polygons(pixels[near])


def _corners(areas: Area) -> Floats:
    """Points (N, 2) just inside the corners of `areas` (K,), and their middles."""
    areas = areas[shapely.area(areas) > _THIN * shapely.length(areas)]
    corners, owner = shapely.get_coordinates(areas, return_index=True)
    middles = shapely.get_coordinates(shapely.centroid(areas))
    if not len(middles):
        return np.zeros((0, 2))
    return np.concatenate([corners + _INWARD * (middles[owner] - corners), middles])
