"""The coarse occlusion relation of a posed pair, by exact outlines and depth (§3.5-3.7).

| common interior of the two images | x first everywhere         | y first everywhere | each first somewhere |
|-----------------------------------|----------------------------|--------------------|----------------------|
| none (DC, EC)                     | non_occludes               | the same           | the same             |
| some, the hinder image sticks out | partially_occludes         | ..._occluded_by    | mutually_occludes    |
| some, the hinder image is covered | totally_occludes           | ..._occluded_by    | mutually_occludes    |

In front is the surface that a line of sight meets first. Exactly one relation holds of any pair; R(x, y) is the
converse of R(y, x). Where neither is first anywhere (coincident surfaces) nothing is in front: non_occludes.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import shapely

from geometry.arrays import Floats, Ints, frozen
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid, rotate
from geometry.outline import Area, ideal_outline
from geometry.rays import RayMesh
from geometry.samples import samples_inside

CoarseRelation = Literal[
    "non_occludes",
    "partially_occludes",
    "partially_occluded_by",
    "totally_occludes",
    "totally_occluded_by",
    "mutually_occludes",
]
_CONVERSE: dict[CoarseRelation, CoarseRelation] = {
    "non_occludes": "non_occludes",
    "partially_occludes": "partially_occluded_by",
    "partially_occluded_by": "partially_occludes",
    "totally_occludes": "totally_occluded_by",
    "totally_occluded_by": "totally_occludes",
    "mutually_occludes": "mutually_occludes",
}
TOLERANCE = 0.25  # px: what of an image is thinner than twice this is no interior, and what sticks out less is covered
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

    def depth(self, rays_camera: Floats) -> Floats:
        """Distance (N,) m from the camera's centre along `rays_camera` (N, 3) to the surface; inf for none."""
        ahead = rotate(self.object_from_camera, rays_camera)
        return self.rays.first_hit(np.broadcast_to(self.object_from_camera[:3, 3], ahead.shape), ahead)


def coarse_relation(
    x: PosedSurface,
    y: PosedSurface,
    camera: Camera,
    tolerance: float = TOLERANCE,
    *,
    depth_tolerance: float = DEPTH_TOLERANCE,
    images: tuple[Area, Area] | None = None,
) -> CoarseRelation:
    """The one coarse relation that holds of x and y as `camera` sees them: 'partially_occludes' has x before y.

    `tolerance` (px) says how thin a common image is no interior, and how little may stick out of a total occluder;
    `depth_tolerance` (part of the distance) when two are equally near. Decided on ideal pixels: the relation is
    topological, so a lens does not change it. Use `coarse_relations` for several bodies, which draws each outline once,
    or give the `images` of both (`ideal_outline`) where they are known.
    """
    images = images or (drawn(x, camera), drawn(y, camera))
    return _relation((x, y), images, camera, tolerance, depth_tolerance)


def drawn(surface: PosedSurface, camera: Camera) -> Area:
    """The outline in ideal pixels."""
    return ideal_outline(surface.vertices, surface.triangles, surface.camera_from_object, camera)


def coarse_relations(
    surfaces: list[PosedSurface],
    camera: Camera,
    tolerance: float = TOLERANCE,
    *,
    depth_tolerance: float = DEPTH_TOLERANCE,
) -> dict[tuple[int, int], CoarseRelation]:
    """`coarse_relation` of every ordered pair (i, j), i != j, of `surfaces`."""
    images = [drawn(s, camera) for s in surfaces]
    found: dict[tuple[int, int], CoarseRelation] = {}
    for i, x in enumerate(surfaces):
        for j in range(i + 1, len(surfaces)):
            found[i, j] = _relation((x, surfaces[j]), (images[i], images[j]), camera, tolerance, depth_tolerance)
            found[j, i] = converse(found[i, j])
    return found


def converse(relation: CoarseRelation) -> CoarseRelation:
    """The relation of (y, x) where `relation` is that of (x, y)."""
    return _CONVERSE[relation]


def _relation(
    pair: tuple[PosedSurface, PosedSurface],
    images: tuple[Area, Area],
    camera: Camera,
    tolerance: float,
    depth_tolerance: float,
) -> CoarseRelation:
    """The relation, worked out in an order of the two that does not depend on which came first."""
    swap = (images[1].wkb, pair[1].camera_from_object.tobytes()) < (images[0].wkb, pair[0].camera_from_object.tobytes())
    first, second = (1, 0) if swap else (0, 1)
    if swap:
        pair, images = (pair[1], pair[0]), (images[1], images[0])
    common = _interior(images[0], images[1], tolerance)
    if common.is_empty:
        return "non_occludes"
    a_first, b_first = _in_front(pair, common, camera, depth_tolerance)
    if a_first and b_first:
        return "mutually_occludes"
    if not a_first and not b_first:
        return "non_occludes"
    front, back = (0, 1) if a_first else (1, 0)
    total = _covers(images[front], images[back], tolerance)
    in_front_is_x = (first, second)[front] == 0
    if in_front_is_x:
        return "totally_occludes" if total else "partially_occludes"
    return "totally_occluded_by" if total else "partially_occluded_by"


def _interior(a: Area, b: Area, tolerance: float) -> Area:
    """What the two images share, less a seam of `tolerance` px: empty for DC and for EC."""
    boxes = zip(a.bounds, b.bounds, strict=True)
    (left_a, left_b), (top_a, top_b), (right_a, right_b), (bottom_a, bottom_b) = boxes
    apart = max(left_a, left_b) >= min(right_a, right_b) or max(top_a, top_b) >= min(bottom_a, bottom_b)
    if a.is_empty or b.is_empty or apart:
        return shapely.Polygon()
    with np.errstate(divide="ignore", invalid="ignore"):  # GEOS divides by the turn of edges that run on straight, and copes
        return shapely.intersection(a, b).buffer(-tolerance, join_style="mitre")


def _covers(front: Area, back: Area, tolerance: float) -> bool:
    """Whether the image `back` lies in `front`, but for what sticks out less than `tolerance` px (EQ, TPPi, NTPPi)."""
    with np.errstate(divide="ignore", invalid="ignore"):  # as above
        return bool(front.covers(back) or front.buffer(tolerance, join_style="mitre").covers(back))


def _in_front(
    pair: tuple[PosedSurface, PosedSurface], common: Area, camera: Camera, depth_tolerance: float
) -> tuple[bool, bool]:
    """Whether each of the two is the first that some line of sight through the `common` interior meets."""
    a, b = pair
    uv = samples_inside(common, (a, b), camera)
    ideal = camera.from_pixels(uv)
    rays = np.concatenate([ideal, np.ones((len(ideal), 1))], axis=-1)
    depth_a, depth_b = a.depth(rays), b.depth(rays)
    both = np.isfinite(depth_a) & np.isfinite(depth_b)
    gap = depth_a[both] - depth_b[both]
    margin = depth_tolerance * np.minimum(depth_a[both], depth_b[both])
    return bool((gap < -margin).any()), bool((gap > margin).any())
