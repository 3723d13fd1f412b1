"""The occlusion relation of a posed pair, by exact outlines and depth (§3.5-3.7): ROC-20, and the six coarse ones that it refines.

The outlines decide how the images lie to each other (``geometry.visibility.rcc``); the first surface that a line of
sight meets decides who is in front on the common interior; ``geometry.visibility.roc`` names the twenty. Exactly one
holds of any pair at the stated tolerance, and R(x, y) is the converse of R(y, x), bit for bit: the two are taken in an
order that does not depend on which came first. Where the images share an interior and neither is first anywhere
(coincident surfaces), each is there at once with the other, and the relation is mutual.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats, Ints, frozen
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid, rotate, transform_points
from geometry.visibility.outline import NEAR, Area, ideal_outline
from geometry.visibility.rays import RayMesh
from geometry.visibility.rcc import related
from geometry.visibility.roc import Front, Roc, roc
from geometry.visibility.samples import samples_inside

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

    `tolerance` (px) is that of the images (`geometry.visibility.rcc`); `depth_tolerance` (part of the distance) says
    when two are equally near. Decided on ideal pixels: the relation is topological, so a lens does not change it. Give
    the `images` of both (`drawn`) where they are known.
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
