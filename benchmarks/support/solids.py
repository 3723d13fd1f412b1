"""Bodies that stand, lie on each other or lean, exactly: no vertex of a hull is below what the body stands on.

* ``Solid``: a mesh with its hull, its middle of mass and the faces that it can stand on, in the mesh's frame
* ``Level``: where another thing can stand on a posed body, ``Level(up=array([0.0, 0.0, 1.0]), height=0.2, area=...)``

Everything is in the world's frame, z up, the table at z = 0; metres. A body is its convex hull, evenly filled.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from geometry.bodies.resting import ALIKE, along_plane, resting_faces
from geometry.frames import transform_points

if TYPE_CHECKING:
    from shapely import Polygon

    from geometry.arrays import Floats
    from sensing.simulated.body import TexturedMesh

TOUCHING = 0.0015
"""Metres from its plane up to which a vertex supports: scans are as rough."""
STEEPEST = np.radians(3.0)
"""Tilt of a body's top up to which another is put on it."""
NARROWEST = 0.03
"""Metres across a top, at least; a lying can's is less."""
FULL, SOFT = 0.6, 0.004
"""Share of a top's area that its surface fills, at least, within so many metres below: bowls and mugs are hollow."""
FIRMLY = 0.005
"""Metres from the rim of what holds a body up to under its middle of mass, at least, where it is put on another."""


class Level(NamedTuple):
    """The plane ``up``·x = ``height`` that touches a body from above, and the area over which it is the body's top.

    ``area`` is seen from above.
    """

    up: Floats
    height: float
    area: Polygon


@dataclass(frozen=True, eq=False)
class Solid:
    """A thing of a type, by the type's name; None for a package of no type."""

    label: str | None
    mesh: TexturedMesh

    @cached_property
    def hull(self) -> Any:  # noqa: ANN401 - trimesh is untyped
        """The convex hull."""
        import trimesh

        return trimesh.Trimesh(self.mesh.vertices, self.mesh.triangles, process=False).convex_hull

    @cached_property
    def corners(self) -> Floats:
        """(V, 3) of the hull."""
        return np.asarray(self.hull.vertices, np.float64)

    @cached_property
    def middle(self) -> Floats:
        """(3,) of mass."""
        return np.asarray(self.hull.center_mass, np.float64)

    @cached_property
    def down(self) -> Floats:
        """(K, 3) outward normals of the faces that it stands on, the widest support first.

        They are the facets of its own hull nearest to ``geometry.bodies.resting.resting_faces``.
        """
        normal = np.asarray(self.hull.face_normals)
        reach = (self.hull.triangles[:, 0] * normal).sum(axis=1)
        feet = self.middle + (reach - normal @ self.middle)[:, None] * normal
        still = normal[(feet @ normal.T - reach).max(axis=1) <= 1e-7]
        near = resting_faces(self.mesh.vertices).down @ still.T
        return np.asarray(still[near.argmax(axis=1)[near.max(axis=1) > np.cos(ALIKE)]])

    def middle_at(self, pose: Floats) -> Floats:
        """(3,) the middle of mass where the solid is at ``pose`` (4, 4)."""
        return np.asarray(pose[:3, :3] @ self.middle + pose[:3, 3])

    def upright(self) -> int | None:
        """Which face is below as the mesh's frame has it; None where none is."""
        along = -self.down[:, 2]
        return int(along.argmax()) if len(along) and along.max() > np.cos(2 * ALIKE) else None

    def stood(self, face: int, up: Floats, turn: float) -> Floats:
        """(4, 4) turned so that a face is below on a plane of this unit normal (3,), by ``turn`` about it."""
        from scipy.spatial.transform import Rotation

        down = self.down[face]
        one = np.column_stack([along_plane(-down), -down])
        other = np.column_stack([along_plane(up), up])
        for axes in (one, other):
            axes[:, 0] *= np.sign(np.linalg.det(axes))
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_rotvec(turn * up).as_matrix() @ other @ one.T
        return pose

    def footed(self, pose: Floats, up: Floats, at: Floats) -> Floats:
        """The pose moved so that the body touches the plane of unit normal ``up`` through ``at`` (3,) from above.

        Its middle of mass stands over ``at``, along the normal.
        """
        moved = pose.copy()
        middle = self.middle_at(pose)
        lowest = float((transform_points(pose, self.corners) @ up).min())
        moved[:3, 3] += at - middle + (up @ middle - lowest) * up
        return moved

    def area(self, pose: Floats, up: Floats) -> Polygon:
        """The area, seen from above, of the vertices that touch the plane below it of this unit normal."""
        from shapely import MultiPoint

        places = transform_points(pose, self.corners)
        heights = places @ up
        return MultiPoint(places[heights < heights.min() + TOUCHING, :2]).convex_hull

    def outline(self, pose: Floats) -> Polygon:
        """Seen from above."""
        from shapely import MultiPoint

        return MultiPoint(transform_points(pose, self.corners)[:, :2]).convex_hull

    def top(self, pose: Floats) -> Level | None:
        """Its widest top that is nearly level and full; None where there is none."""
        turn, places = pose[:3, :3], transform_points(pose, self.corners)
        ups = np.asarray(self.hull.face_normals) @ turn.T
        found = [self._level(up, places) for up in ups[ups[:, 2] > np.cos(STEEPEST)]]
        best = max(found, key=lambda level: level.area.area, default=None)
        return best if best is not None and _wide(best.area) and self._full(best, pose) else None

    @staticmethod
    def _level(up: Floats, places: Floats) -> Level:
        from shapely import MultiPoint

        heights = places @ up
        height = float(heights.max())
        return Level(up, height, MultiPoint(places[heights > height - TOUCHING, :2]).convex_hull)

    def _full(self, level: Level, pose: Floats) -> bool:
        """Whether the mesh itself is there, and not only its hull."""
        corners = transform_points(pose, self.mesh.vertices)[self.mesh.triangles]
        up = (corners @ level.up > level.height - SOFT).all(axis=1)
        flat = np.cross(corners[up, 1] - corners[up, 0], corners[up, 2] - corners[up, 0])[:, 2] / 2.0
        return float(flat[flat > 0.0].sum()) >= FULL * level.area.area


def _wide(area: Polygon) -> bool:
    """Whether a body may stand there: its narrowest box is not too narrow."""
    box = np.array(area.minimum_rotated_rectangle.exterior.coords) if area.area > NARROWEST**2 else np.zeros((3, 2))
    return bool(np.linalg.norm(np.diff(box[:3], axis=0), axis=1).min() >= NARROWEST)


def holds(area: Polygon, middle: Floats, firmly: float = FIRMLY) -> bool:
    """Whether a middle of mass (3,) is over an area, and so far within its rim (m)."""
    from shapely import Point

    return bool(area.buffer(-firmly).contains(Point(middle[:2])))


def until_touching(moved: Floats, other: Floats, along: Floats) -> tuple[float, Floats] | None:
    """How far (m) the hull of corners (V, 3) can go along a direction (3,) until it touches that of others (W, 3).

    And where they touch (3,); None where they never do. They are apart at first.
    """
    from scipy.optimize import linprog

    v, w = len(moved), len(other)
    same = np.hstack([moved.T, -other.T, along[:, None]])
    ones = np.zeros((2, v + w + 1))
    ones[0, :v] = ones[1, v : v + w] = 1.0
    found = linprog(np.r_[np.zeros(v + w), 1.0], A_eq=np.vstack([same, ones]), b_eq=[0, 0, 0, 1, 1], bounds=(0, None))
    return (float(found.x[-1]), other.T @ found.x[v : v + w]) if found.success else None
