"""How bodies rest on a plane: the faces that each can stand on, and the moves that leave it standing.

* ``Plane``: ``Plane(up=array([0.0, -1.0, 0.0]), offset=0.4)``, the places x with up·x + offset = 0; what rests on it is
  above
* ``RestingFaces``: of one body, the planes that touch it from below where it stands still
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

GRAIN = 0.01
"""Share of the body's size to which its corners are rounded: what is smaller tips nobody."""
ALIKE = 0.14
"""Radians by less than which two faces differ that are told as one, that of the larger support."""
FIRM = 0.001
"""Least way from under the middle of mass to the rim of its support, a share of the size; more would lack faces that
bulging things lie on."""


@dataclass(frozen=True)
class Plane:
    """Places x with ``up``·x + ``offset`` = 0; ``up`` (3,) is a unit vector, ``offset`` in metres, both in one frame, the camera's as a rule."""

    up: Floats
    offset: float

    def height(self, places: Floats) -> Floats:
        """(...,) metres of ``places`` (..., 3) above the plane."""
        return np.asarray(places @ self.up + self.offset)

    @property
    def moves(self) -> Floats:
        """(6, 3) the steps (w, v) of ``geometry.poses.refine`` that leave resting what rests: a turn about ``up``, and two moves along the plane."""
        result = np.zeros((6, 3))
        result[:3, 0], result[3:, 1:] = self.up, _along(self.up)
        return result


@dataclass(frozen=True)
class RestingFaces:
    """``down`` (K, 3) unit normals, out of the body; ``reach`` (K,) m, down·x of the face: its distance below the frame's origin."""

    down: Floats
    reach: Floats

    def planes(self, pose: Floats) -> tuple[Floats, Floats]:
        """``up`` (K, 3) and ``offset`` (K,) of the planes that a body at ``pose`` (4, 4) would stand on, in the frame that it is posed in."""
        up = -self.down @ pose[:3, :3].T
        return up, self.reach - up @ pose[:3, 3]


def resting_faces(points: Floats) -> RestingFaces:
    """Of the body that is the hull of ``points`` (N, 3) m, evenly filled; the widest support first. Points of a plane have none."""
    from scipy.spatial import ConvexHull, QhullError

    none = RestingFaces(np.zeros((0, 3)), np.zeros(0))
    if not len(points):
        return none
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    grain = max(GRAIN * size, 1e-12)
    try:
        hull: Any = ConvexHull(np.unique(np.round(points / grain), axis=0) * grain)
    except QhullError:  # of no volume
        return none
    normal, reach = hull.equations[:, :3], -hull.equations[:, 3]
    corners = hull.points[hull.simplices]
    middle = _middle_of_mass(corners, hull.points[hull.vertices].mean(axis=0))
    below = _over(normal, reach, middle, grain / 2.0)
    supports = [_support(hull.points[hull.vertices], normal[i], reach[i], middle, grain) for i in below]
    order = sorted((i for i, (firm, _) in enumerate(supports) if firm > FIRM * size), key=lambda i: -supports[i][1])
    kept: list[int] = []
    for i in below[order]:
        if all(normal[i] @ normal[k] < np.cos(ALIKE) for k in kept):
            kept.append(int(i))
    return RestingFaces(normal[kept], (points @ normal[kept].T).max(axis=0))


def _along(normal: Floats) -> Floats:
    """(3, 2) two unit vectors along a plane of this unit normal (3,), at right angles."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)], axis=1)


def _middle_of_mass(corners: Floats, inside: Floats) -> Floats:
    """(3,) of the body whose surface is the triangles (T, 3, 3) around a place inside."""
    spokes = corners - inside
    volume = np.abs(np.linalg.det(spokes))
    return np.asarray(inside + (volume[:, None] * spokes.sum(axis=1)).sum(axis=0) / (4.0 * volume.sum()))


def _over(normal: Floats, reach: Floats, middle: Floats, slack: float) -> NDArray[np.intp]:
    """Which faces, of normals (T, 3), the middle of mass (3,) is straight above, were they below: its foot is in the body, ``slack`` aside (m)."""
    feet = middle + (reach - normal @ middle)[:, None] * normal
    return np.flatnonzero((feet @ normal.T - reach).max(axis=1) <= slack)


def _support(vertices: Floats, normal: Floats, reach: float, middle: Floats, grain: float) -> tuple[float, float]:
    """How far inside its support the middle of mass is (m, negative outside), and the support's area (m²); of vertices (V, 3) about a face."""
    from scipy.spatial import ConvexHull

    axes = _along(normal)
    held: Any = ConvexHull(vertices[vertices @ normal > reach - grain / 2.0] @ axes)
    return -float((held.equations[:, :2] @ (middle @ axes) + held.equations[:, 2]).max()), float(held.volume)
