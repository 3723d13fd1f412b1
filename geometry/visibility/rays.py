"""Rays against one surface, with one Embree structure built once, in the surface's own frame.

Embree finds the triangle in single precision; the distance is then taken to that triangle's plane in double precision.

Behind(y, x, v): the line of sight from v to y meets x strictly before y (formalism §3.4).
"""

import os
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import Floats, Ints, Mask, frozen, frozen_ints, last_axes, lengths, summed
from geometry.errors import GeometryError
from geometry.frames import inverse, transform_points
from geometry.room import check_room, check_threads

TOLERANCE = 0.005  # of the surface's size: a feature's own facets at the feature do not hide it


_DEVICE, _TRIANGLE = 340 << 20, 1400
"""Bytes of address space that are wanted before Embree starts, and for each triangle: a quarter more than it takes, 272
MB with two processors, and 1.1 kB of meshes of 40,000 triangles and of 400,000."""
_GRAZING = 1e-9  # sine of the angle to a plane below which Embree's own distance is kept


class RayMesh:
    """A surface ready to be shot at: `vertices` (V, 3) m and `triangles` (T, 3), both read-only.

    Raises:
        GeometryError: for an empty surface, a coordinate that is not finite, or an index out of range.
        MemoryError: where Embree would need more than there is.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        """Check the surface, and build its acceleration structure."""
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self.vertices, self.triangles = checked_mesh(vertices, triangles)
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.size = float(np.linalg.norm(high - low))  # m, diagonal of the box round it, of this ``centre`` (3,)
        self.centre, self._scale = (low + high) / 2, 2.0 / max(self.size, 1e-300)
        corners = self.vertices[self.triangles]
        self._corner = corners[:, 0]
        self._normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        check_room(_TRIANGLE * len(self.triangles))
        self._scene = EmbreeScene(device=_device(), robust=True)  # no cracks along shared edges
        unit = ((self.vertices - self.centre) * self._scale).astype(np.float32)
        self._mesh = TriangleMesh(self._scene, unit, self.triangles.astype(np.int32))

    def first_hit(self, origins: ArrayLike, directions: ArrayLike) -> Floats:
        """Distance (N,) m from `origins` (N, 3) along `directions` (N, 3), of any length, to the surface; inf for none.

        A direction of zero and a ray that is not finite hit nothing. Both sides of a triangle are hit.
        """
        return self.first_triangle(origins, directions)[0]

    def first_triangle(self, origins: ArrayLike, directions: ArrayLike) -> tuple[Floats, Ints]:
        """As `first_hit`, and the index (N,) of the triangle that is hit, -1 for none."""
        start, unit, alive = _rays(origins, directions)
        if alive is None:
            return self._shoot(start, unit)
        distance, triangle = np.full(len(alive), np.inf), np.full(len(alive), -1, dtype=np.int64)
        if alive.any():
            distance[alive], triangle[alive] = self._shoot(start, unit)
        return distance, triangle

    def meets(self, origins: ArrayLike, directions: ArrayLike) -> Mask:
        """Mask (N,): whether rays as of `first_hit` hit the surface at all."""
        start, unit, alive = _rays(origins, directions)
        found = np.zeros(len(unit) if alive is None else len(alive), bool)
        if len(unit):
            near, fine, _ = self._near(start, unit)
            found[slice(None) if alive is None else alive] = self._scene.run(near, fine) >= 0
        return found

    def seen_from(self, eye: Floats, unit: NDArray[np.float32]) -> NDArray[np.int32]:
        """The index (N,) of the triangle that each of unit vectors (N, 3) from one place (3,) m meets first, or -1."""
        lead = max(0.0, float(np.linalg.norm(eye - self.centre)) - self.size)
        near = np.float32(lead * self._scale) * unit + ((eye - self.centre) * self._scale).astype(np.float32)
        return np.asarray(self._scene.run(near, unit), np.int32)

    def times(self, eye: Floats, along: Floats) -> Floats:
        """How many times each of vectors (N, 3), none 0, leads from one place (3,) m to the surface; inf for never."""
        triangle = self.seen_from(eye, (along / lengths(along)[:, None]).astype(np.float32))
        hit = np.flatnonzero(triangle >= 0)
        way, corner, result = along[hit], self._corner[triangle[hit]] - eye, np.full(len(along), np.inf)
        exact = self._to_planes(eye, way, triangle[hit])
        beside = summed(corner * way) / summed(way * way)  # the foot of the first corner, which is no farther off
        result[hit] = np.where(np.abs(exact - beside) * lengths(way) < self.size, exact, beside)
        return result

    def blocks(self, viewpoint: ArrayLike, points: ArrayLike, tolerance: float) -> Mask:
        """Mask (N,): the segment from `viewpoint` to a point (N, 3) is cut `tolerance` m or more before it ends.

        `viewpoint` is one for all points, (3,), or one for each, (N, 3). This is Behind (§3.4): the tolerance excludes
        a feature's own facets at the feature.
        """
        eye, targets = last_axes(viewpoint, (3,), "viewpoint"), last_axes(points, (-1, 3), "points")
        hit = self.first_hit(np.atleast_2d(eye), targets - eye)
        return np.asarray(hit < lengths(targets - eye) - tolerance)

    def _shoot(self, start: Floats, unit: Floats) -> tuple[Floats, Ints]:
        """Distances and triangles of finite rays with unit directions, from places (N, 3) or all from one, (1, 3)."""
        near, fine, lead = self._near(start, unit)
        answer = self._scene.run(near, fine, output=True)
        distance, triangle = np.full(len(unit), np.inf), np.asarray(answer["primID"], dtype=np.int64)
        hit = np.flatnonzero(triangle >= 0)
        one = len(start) == 1
        rough = np.asarray(answer["tfar"][hit], dtype=np.float64) / self._scale + (lead if one else lead[hit])
        distance[hit] = self._exact(start if one else start[hit], unit[hit], triangle[hit], rough)
        return distance, triangle

    def _near(self, start: Floats, unit: Floats) -> tuple[NDArray[np.float32], NDArray[np.float32], Floats]:
        """Rays begun at the sphere round the surface, which keeps single precision fine, and how far on that is."""
        lead = np.maximum(0.0, lengths(start - self.centre) - self.size)
        near = ((start + lead[:, None] * unit - self.centre) * self._scale).astype(np.float32)
        return near, unit.astype(np.float32), lead

    def _exact(self, start: Floats, unit: Floats, triangle: Ints, rough: Floats) -> Floats:
        """Distances (N,) to the planes of the triangles hit; Embree's where the ray grazes or the two do not agree."""
        distance = self._to_planes(start, unit, triangle)
        return np.where(np.abs(distance - rough) < 1e-3 * self.size, distance, rough)

    def _to_planes(self, start: Floats, way: Floats, triangle: NDArray[np.integer[Any]]) -> Floats:
        """How many times each vector (N, 3) leads from its start to the plane of its triangle; NaN where it grazes."""
        normal = self._normals[triangle]
        sink = summed(normal * way)
        steep = np.abs(sink) > _GRAZING * lengths(normal) * lengths(way)
        rise = summed(normal * (self._corner[triangle] - start))
        return np.divide(rise, sink, out=np.full(len(rise), np.nan), where=steep)


def _rays(origins: ArrayLike, directions: ArrayLike) -> tuple[Floats, Floats, Mask | None]:
    """Places and unit directions of the rays that can hit something, and which of all (N,) these are, None: all.

    The places are (1, 3) where all rays start at one and can hit something.
    """
    start, ray = last_axes(origins, (-1, 3), "origins"), last_axes(directions, (-1, 3), "directions")
    shape = np.broadcast_shapes(start.shape, ray.shape)
    length = lengths(ray)
    alive = np.broadcast_to(np.isfinite(start).all(axis=-1) & np.isfinite(length) & (length > 0), shape[:1])
    if alive.all():
        return start, np.broadcast_to(ray / length[:, None], shape), None
    start, ray, length = np.broadcast_to(start, shape), np.broadcast_to(ray, shape), np.broadcast_to(length, shape[:1])
    return start[alive], ray[alive] / length[alive, None], alive


@cache
def _device() -> Any:  # noqa: ANN401 - it has no stubs
    """The one device of all surfaces.

    Each of its own costs threads, and about a thousand of them are the most that a process can have.
    """
    from embreex.rtcore import EmbreeDevice

    check_room(_DEVICE)
    check_threads(os.cpu_count() or 1)
    return EmbreeDevice()


def checked_mesh(vertices: ArrayLike, triangles: ArrayLike) -> tuple[Floats, Ints]:
    """Read-only `vertices` (V, 3) and `triangles` (T, 3) of a surface that can be used at all.

    Raises:
        GeometryError: for an empty surface, a coordinate that is not finite, or an index out of range.
    """
    places, facets = frozen(last_axes(vertices, (-1, 3), "vertices")), frozen_ints(triangles)
    if facets.ndim != 2 or facets.shape[1] != 3 or not len(facets) or not len(places):
        raise GeometryError(
            f"triangles must have the shape (T >= 1, 3), not {facets.shape}, over {len(places)} vertices"
        )
    if not np.isfinite(places).all():
        raise GeometryError(f"vertex {int(np.argmin(np.isfinite(places).all(axis=1)))} must be finite")
    if facets.min() < 0 or facets.max() >= len(places):
        raise GeometryError(f"triangles must index the {len(places)} vertices, not {facets.min()} to {facets.max()}")
    return places, facets


def behind(
    points_camera: ArrayLike, mesh: RayMesh, camera_from_object: ArrayLike, tolerance: float | None = None
) -> Mask:
    """Mask (N,) of the `points_camera` (N, 3) m that the surface `mesh`, posed, hides from the camera's centre.

    The points go into the surface's own frame, so one structure serves every pose of a type. `tolerance` (m) is how far
    before a point the surface must be met, by default 0.005 of the surface's size. NaN points are behind nothing.
    """
    object_from_camera = inverse(last_axes(camera_from_object, (4, 4), "camera_from_object"))
    margin = TOLERANCE * mesh.size if tolerance is None else tolerance
    return mesh.blocks(
        object_from_camera[:3, 3], transform_points(object_from_camera, np.asarray(points_camera)), margin
    )


def depth_of(mesh: RayMesh, camera_from_object: Floats, K: Floats, size: tuple[int, int]) -> Floats:
    """Depths (h, w), m along the optical axis, of a posed surface; inf where it is not.

    ``camera_from_object`` (4, 4), ``K`` (3, 3) of a camera without a lens, ``size`` the picture's width and height.
    """
    result = np.full(size[::-1], np.inf)
    left, right = _span(mesh, camera_from_object, K, size[0], 0)
    top, bottom = _span(mesh, camera_from_object, K, size[1], 1)
    if left < right and top < bottom:
        sights = np.ones((bottom - top, right - left, 3))
        sights[..., 0] = (np.arange(left, right) - K[0, 2]) / K[0, 0]
        sights[..., 1] = ((np.arange(top, bottom) - K[1, 2]) / K[1, 1])[:, None]
        result[top:bottom, left:right] = mesh.times(
            inverse(camera_from_object)[:3, 3], sights.reshape(-1, 3) @ camera_from_object[:3, :3]
        ).reshape(sights.shape[:2])
    return result


def _span(mesh: RayMesh, pose: Floats, K: Floats, number: int, axis: int) -> tuple[int, int]:
    """From which to before which of ``number`` pixels along an axis the ball around a posed surface is seen."""
    middle, radius = transform_points(pose, mesh.centre[None])[0], 0.5 * mesh.size * (1.0 + TOLERANCE)
    aside, ahead = middle[axis], middle[2]
    if ahead <= radius:  # it is about the camera, or behind it
        return 0, number
    reach = radius * np.sqrt(max(aside**2 + ahead**2 - radius**2, 0.0))
    ends = (aside * ahead + np.array([-reach, reach])) / (ahead**2 - radius**2) * K[axis, axis] + K[axis, 2]
    low, high = np.clip([np.floor(ends[0]), np.ceil(ends[1]) + 1.0], 0.0, number)
    return int(low), int(high)
