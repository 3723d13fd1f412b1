"""How bodies rest: the faces that each can stand on, the moves that leave it standing, and where two bodies touch.

* ``Plane``: ``Plane(up=array([0.0, -1.0, 0.0]), offset=0.4)``, the places x with up·x + offset = 0; what rests on it is
  above
* ``RestingFaces``: of one body, the planes that touch it from below where it stands still, and how often it stands so

Contacts are the closest places of two posed bodies, by a client of pybullet that the caller opens. A body is its convex
parts where it can be cut into them exactly. What cannot (a scan, a surface that is not closed) is its hull where it is
asked what it stands on, and its own facets where it is asked what stands on it; of more than ``MOST_FACETS``, its hull
there too.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Floats, Ints

GRAIN = 0.01
"""Share of the body's size within which corners are as low as a face: scans are as rough."""
EXACT = 1e-9
"""The same within which the middle of mass is above a facet's rim, so that two which share a plane lack nothing."""
ALIKE = 0.14
"""Radians by less than which two faces differ that are told as one, that of the larger support."""
ROUND = 6
"""Decimals to which two directions are one."""
SNAP = 0.175
"""Radians, 10 degrees, within which a stated direction means the nearest face that the body stands on."""
EQUAL = 0.02, 2.0
"""Two ways to stand are alike, as the sides of a can are, where the middle of mass is equally high up to this share of
the size, and the supports' areas differ by less than this factor."""


@dataclass(frozen=True)
class Plane:
    """Places x with ``up``·x + ``offset`` = 0.

    ``up`` (3,) is a unit vector, ``offset`` in metres, both in one frame, the camera's as a rule.
    """

    up: Floats
    offset: float

    def height(self, places: Floats) -> Floats:
        """(...,) metres of ``places`` (..., 3) above the plane."""
        return np.asarray(places @ self.up + self.offset)

    def turned(self, other: "Plane") -> float:
        """Radians between the normals of two planes."""
        return float(np.arccos(np.clip(self.up @ other.up, -1.0, 1.0)))

    @property
    def moves(self) -> Floats:
        """(6, 3) the steps (w, v) of ``geometry.poses.refine`` that leave resting what rests.

        They are a turn about ``up``, and two moves along the plane.
        """
        result = np.zeros((6, 3))
        result[:3, 0], result[3:, 1:] = self.up, self.along
        return result

    @cached_property
    def along(self) -> Floats:
        """(3, 2) as of ``along_plane``."""
        return along_plane(self.up)


@dataclass(frozen=True)
class RestingFaces:
    """``down`` (K, 3) unit normals, out of the body.

    ``reach`` (K,) m, down·x of the face: its distance below the frame's origin. ``weight`` (K,): P(it stands on that
    face, given that it stands), of sum 1. Standing there it is ``tall`` (K,) m, and reaches ``wide`` (K,) m to its
    sides, on average. ``bent`` (K,) rad: what it bulges there, the standard deviation about each axis.
    """

    down: Floats
    reach: Floats
    weight: Floats
    tall: Floats
    wide: Floats
    bent: Floats

    def planes(self, pose: Floats) -> tuple[Floats, Floats]:
        """``up`` (K, 3) and ``offset`` (K,) of the planes under a body at ``pose`` (4, 4), in its frame."""
        up = -self.down @ pose[:3, :3].T
        return up, self.reach - up @ pose[:3, 3]


def resting_faces(points: Floats) -> RestingFaces:
    """Of the body that is the hull of ``points`` (N, 3) m, evenly filled; the widest support first.

    A facet of the hull holds it whose own area is straight below the middle of mass. Facets that are ``ALIKE`` are told
    as that of the widest support, and how far the others are turned from it. Points of a plane have none. Each
    different way to stand has the same weight; faces that are alike (``EQUAL``) are one way, and share it.
    """
    from scipy.spatial import ConvexHull, QhullError

    none = _faces(points, np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    if not len(points):
        return none
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    try:
        hull: Any = ConvexHull(points)
    except QhullError:  # of no volume
        return none
    corners, vertices = hull.points[hull.simplices], hull.points[hull.vertices]
    middle = _middle_of_mass(corners, vertices.mean(axis=0))
    below = _below(corners, hull.equations[:, :3], middle, EXACT * size)
    normal, reach = hull.equations[below, :3], -hull.equations[below, 3]
    area = np.array([_area(vertices, *row, GRAIN * size) for row in zip(normal, reach, strict=True)])
    kept: list[int] = []
    for i in np.argsort(-np.round(area / size**2, ROUND), kind="stable"):
        if all(normal[i] @ normal[k] < np.cos(ALIKE) for k in kept):
            kept.append(int(i))
    down = normal[kept]
    reach = (points @ down.T).max(axis=0)
    return _faces(points, down, _shared((reach - down @ middle) / size, area[kept]), _bent(normal, down))


def _bent(normal: Floats, down: Floats) -> Floats:
    """(K,) rad: how far facets' normals (T, 3) are off the nearest of ``down`` (K, 3), about each axis, on average."""
    angle = np.arccos(np.clip(normal @ down.T, -1.0, 1.0))
    nearest = angle.argmin(axis=1)
    count = np.bincount(nearest, minlength=len(down))
    return np.asarray(np.sqrt(np.bincount(nearest, angle.min(axis=1) ** 2, minlength=len(down)) / (2.0 * count)))


def stated_faces(points: Floats, down: Floats, weight: Floats) -> RestingFaces:
    """Of the hull of ``points`` (N, 3) m, the faces meant by directions ``down`` (S, 3), unit; the heaviest first.

    ``weight`` (S,) above 0, of any sum. Each direction means the face that ``meant`` says; where that is none, the
    plane that touches the hull in that very direction. What means one face adds up.
    """
    faces, weight = resting_faces(points), weight / weight.max()  # of huge ones the sum would overflow
    which = meant(faces, down)
    found = np.where(which[:, None] >= 0, np.concatenate([faces.down, np.zeros((1, 3))])[which], down)
    _, first, place = np.unique(np.round(found, ROUND), axis=0, return_index=True, return_inverse=True)
    total = np.bincount(place.ravel(), weights=weight) / weight.sum()
    order = np.lexsort((first, -np.round(total, ROUND)))
    kept = first[order]
    return _faces(points, found[kept], total[order], np.append(faces.bent, 0.0)[which[kept]])


def _faces(points: Floats, down: Floats, weight: Floats, bent: Floats) -> RestingFaces:
    """The faces of normals (K, 3) of the hull of ``points`` (N, 3) m."""
    if not len(down):
        return RestingFaces(down, np.zeros(0), weight, np.zeros(0), np.zeros(0), bent)
    along = points @ down.T
    wide = [0.5 * float(np.ptp(points @ along_plane(one), axis=0).mean()) for one in down]
    return RestingFaces(down, along.max(axis=0), weight, np.ptp(along, axis=0), np.array(wide), bent)


def meant(faces: RestingFaces, down: Floats) -> Ints:
    """(S,) the face nearest to each direction (S, 3), unit; -1 where none is within ``SNAP``."""
    if not len(faces.down):
        return np.full(len(down), -1)
    near = down @ faces.down.T
    return np.where(near.max(axis=1) >= np.cos(SNAP), near.argmax(axis=1), -1)


def along_plane(normal: Floats) -> Floats:
    """(3, 2) two unit vectors along a plane of this unit normal (3,), at right angles."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)], axis=1)


def _shared(height: Floats, area: Floats) -> Floats:
    """(K,) weights of faces: see ``EQUAL``.

    By the ``height`` (K,) of the middle of mass, a share of the size, and the ``area`` (K,).
    """
    from scipy.sparse.csgraph import connected_components

    level = np.abs(height[:, None] - height) < EQUAL[0]
    kinds, kind = connected_components(level & (np.abs(np.log(area[:, None] / area)) < np.log(EQUAL[1])))
    return np.asarray(1.0 / (kinds * np.bincount(kind)[kind]))


def _middle_of_mass(corners: Floats, inside: Floats) -> Floats:
    """(3,) of the body whose surface is the triangles (T, 3, 3) around a place inside."""
    spokes = corners - inside
    volume = np.abs(np.linalg.det(spokes))
    return np.asarray(inside + (volume[:, None] * spokes.sum(axis=1)).sum(axis=0) / (4.0 * volume.sum()))


def _below(corners: Floats, normal: Floats, middle: Floats, slack: float) -> Ints:
    """Which facets (T, 3, 3), of normals (T, 3), the middle of mass (3,) is straight above, were they below.

    Its foot is in the facet, or ``slack`` aside (m).
    """
    foot = middle + ((corners[:, 0] - middle) * normal).sum(axis=1)[:, None] * normal
    first, second, third = (corners[:, i] - foot for i in range(3))
    turns = [np.cross(a, b) for a, b in ((first, second), (second, third), (third, first))]
    turn = np.stack([(some * normal).sum(axis=1) for some in turns], axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return np.flatnonzero((turn * np.sign(turn.sum(axis=1))[:, None]).min(axis=1) >= -slack * longest)


def _area(vertices: Floats, normal: Floats, reach: float, grain: float) -> float:
    """The area (m²) of the support of vertices (V, 3) that are as low as a face, to half a grain."""
    from scipy.spatial import ConvexHull

    held: Any = ConvexHull(vertices[vertices @ normal > reach - grain / 2.0] @ along_plane(normal))
    return float(held.volume)


MOST_FACETS = 50_000
"""Facets of a body beyond which its hull stands in for it: more do not fit what pybullet takes."""
UNITS = 100.0
"""Of pybullet, in one length that matters: the margin of a thousandth that it puts around bodies is 0.00001 of that."""


class Shape(NamedTuple):
    """``parts``: corners (V, 3) m of convex bodies that fill it.

    Where it is ``rough``, of its hull, and ``facets``, (V, 3) m and (T, 3), if few.
    """

    parts: tuple[Floats, ...]
    facets: tuple[Floats, Ints] | None = None
    rough: bool = False

    @property
    def heights(self) -> tuple[float, float]:
        """Its lowest and its highest place, m along z."""
        heights = np.concatenate([part[:, 2] for part in self.parts])
        return float(heights.min()), float(heights.max())


class Touch(NamedTuple):
    """``gap`` m, negative where bodies reach into each other; ``normal`` (3,), unit, towards the upper.

    ``at`` (3,) m, on the lower.
    """

    gap: float
    normal: Floats
    at: Floats


def shape_of(parts: Iterable[Floats], vertices: Floats, triangles: Ints, *, exact: bool) -> Shape:
    """Of a body whose convex ``parts`` fill it where ``exact``; else its hull and facets."""
    if exact:
        return Shape(tuple(parts))
    return Shape(
        (hull_corners(vertices),), (vertices, triangles) if len(triangles) <= MOST_FACETS else None, rough=True
    )


def hull_corners(vertices: Floats) -> Floats:
    """Those of the vertices (V, 3) that their hull needs; all of them where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(vertices[np.sort(ConvexHull(vertices).vertices)])
    except QhullError:
        return vertices


class Bodies:
    """Shapes in a client of pybullet, each loaded when it is first asked for.

    ``length`` m is what gaps are to be exact against.
    """

    def __init__(self, bullet: Any, number: int, shapes: dict[str, Shape], length: float) -> None:  # noqa: ANN401 - pybullet is untyped
        self.bullet, self.number, self.shapes = bullet, number, shapes
        self.scale = UNITS / length
        corners = [part for shape in shapes.values() for part in shape.parts]
        self.middle = np.concatenate(corners).mean(axis=0) if corners else np.zeros(3)
        self.loaded: dict[tuple[str, int], int] = {}

    def touches(self, upper: str, lower: str, reach: float) -> Iterator[Touch]:
        """Where the two are at most ``reach`` m apart; of facets, one a facet."""
        below = self.shapes[lower]
        others = enumerate(below.parts) if below.facets is None else [(-1, below.facets[0])]
        for (i, part), (j, other) in product(enumerate(self.shapes[upper].parts), others):
            if _near(part, other, reach):
                one, two = self._load((upper, i), part), self._load((lower, j), other, below.facets)
                for row in self.bullet.getClosestPoints(one, two, reach * self.scale, physicsClientId=self.number):
                    at = np.array(row[6]) / self.scale + self.middle
                    yield Touch(float(row[8]) / self.scale, np.array(row[7]), at)

    def _load(self, key: tuple[str, int], corners: Floats, facets: tuple[Floats, Ints] | None = None) -> int:
        """The client's number of a convex body with these corners (V, 3) m, or of facets."""
        if key not in self.loaded:
            flags = {"flags": self.bullet.GEOM_FORCE_CONCAVE_TRIMESH}
            more = {} if facets is None else {"indices": facets[1].ravel().tolist(), **flags}
            placed = ((corners - self.middle) * self.scale).tolist()
            shape = self.bullet.createCollisionShape(
                self.bullet.GEOM_MESH, vertices=placed, physicsClientId=self.number, **more
            )
            self.loaded[key] = int(self.bullet.createMultiBody(0, shape, physicsClientId=self.number))
        return self.loaded[key]


def _near(one: Floats, other: Floats, reach: float) -> bool:
    """Whether the boxes around both, along the axes, are at most ``reach`` apart along each."""
    apart = np.maximum(one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0))
    return bool((apart <= reach).all())
