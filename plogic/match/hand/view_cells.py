"""View cells: what one type looks like from each of a set of directions.

A cell is a viewpoint direction in the object's frame, computed once a type. Features that are visible in one cell have
lobes that contain one common viewpoint, so that sets taken inside a cell are co-visible by construction (*convergence*,
§6.3). A vote says how many distinctive features of a coarse pose find an appearance of a right type near their place.

* ``view_cells(object_type)``: the cells of a type
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Indices, Mask
from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import feature_in_lobe

CELLS = 162
"""Directions on the sphere: neighbours are about 15° apart, so that a true viewpoint is mostly within 9° of a cell
(12.1° at worst)."""
DISTANCE = 3.0
"""Nominal distance of a cell's viewpoint, in diameters of the type."""
RAYS = 1 << 15
"""The most rays cast at once: what they take of memory stays below 10 MB."""


@dataclass(frozen=True)
class ViewCells:
    """One type seen from C directions; F features, at most K arms each.

    ``directions`` (C, 3) unit, object frame, from the centre to the viewpoint; ``cell_from_object`` (C, 3, 3) rotations
    to a camera there that looks at the centre; ``xy`` (C, F, 2) metres in the plane through the centre, x right and y
    down, after perspective division; ``visible`` (C, F): in a lobe and not Behind the type's own surface; ``arms`` (C,
    F, K) screen angles of the visible edges at a feature, radians, NaN where there is none.
    """

    directions: Floats
    cell_from_object: Floats
    xy: Floats
    visible: Mask
    arms: Floats
    centre: Floats
    diameter: float

    def nearest(self, directions: Floats) -> Indices:
        """Index of the nearest cell to each unit direction (N, 3) in the object's frame, shape (N,)."""
        return np.asarray(np.argmax(directions.astype(np.float32) @ self.directions.T.astype(np.float32), axis=1))


def fibonacci_sphere(number: int) -> Floats:
    """``number`` near-uniform unit directions (number, 3), the same for the same number."""
    index = np.arange(number) + 0.5
    z = 1.0 - 2.0 * index / number
    azimuth = np.pi * (1.0 + 5.0**0.5) * index
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=1)


def looking_back(directions: Floats) -> Floats:
    """Rotations (C, 3, 3) of cameras at ``directions`` that look at the centre, object's z up on the screen."""
    forward = -directions
    up = np.where(np.abs(directions[:, 2:3]) > 0.999, [[0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return np.stack([right, np.cross(forward, right), forward], axis=1)


def view_cells(object_type: ObjectType, number: int = CELLS) -> ViewCells:
    """Precompute the cells of a type with a surface. Rays are cast for Behind only here, not per hypothesis."""
    positions = np.array([feature.at for feature in object_type.seen_features])
    centre, diameter = _bounds(object_type)
    directions = fibonacci_sphere(number)
    rotations = looking_back(directions)
    viewpoints = centre + DISTANCE * diameter * directions
    along, owner, slot = _along_arms(object_type, diameter)
    points, count = np.concatenate([positions, along]), len(positions)
    local = np.einsum("cij,cnj->cni", rotations, points[None] - viewpoints[:, None])
    xy = local[..., :2] / local[..., 2:]
    hidden = _behind_itself(object_type, viewpoints, points, diameter)
    step = xy[:, count:] - xy[:, owner]
    arms = np.full((number, count, int(slot.max(initial=-1)) + 1), np.nan)
    arms[:, owner, slot] = np.where(hidden[:, count:], np.nan, np.arctan2(step[..., 1], step[..., 0]))
    visible = feature_in_lobe(object_type.lobes, viewpoints) & ~hidden[:, :count]
    return ViewCells(directions, rotations, xy[:, :count] * (DISTANCE * diameter), visible, arms, centre, diameter)


def _along_arms(object_type: ObjectType, diameter: float) -> tuple[Floats, Indices, Indices]:
    """A point (N, 3) a little way along each edge, its feature (N,) and the edge's number there (N,)."""
    rows = [
        (feature.at + 0.05 * diameter * arm, f, k)
        for f, feature in enumerate(object_type.seen_features)
        for k, arm in enumerate(feature.arms)
    ]
    owner, slot = (np.array([row[i] for row in rows], np.intp) for i in (1, 2))
    return np.array([row[0] for row in rows]).reshape(-1, 3), owner, slot


def remade(object_type: ObjectType, xy: Floats, visible: Mask, arms: Floats) -> ViewCells:
    """The cells of a type of which what takes time is known."""
    directions = fibonacci_sphere(len(xy))
    return ViewCells(directions, looking_back(directions), xy, visible, arms, *_bounds(object_type))


def _bounds(object_type: ObjectType) -> tuple[Floats, float]:
    """Middle (3,) and diagonal of the box round a type's surface, or round its features where it has none."""
    surface = object_type.surface
    points = np.array([feature.at for feature in object_type.seen_features]) if surface is None else surface.vertices
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2.0, float(np.linalg.norm(high - low)) or 1.0


def _behind_itself(object_type: ObjectType, viewpoints: Floats, points: Floats, diameter: float) -> Mask:
    """(C, N) whether each point is Behind the type's own surface from each viewpoint (§3.4).

    Nothing is where there is no opaque surface.
    """
    if object_type.surface is None or not object_type.opaque:
        return np.zeros((len(viewpoints), len(points)), dtype=bool)
    rays, several = object_type.surface.rays, max(1, RAYS // max(1, len(points)))
    hidden = [
        rays.blocks(np.repeat(some, len(points), axis=0), np.tile(points, (len(some), 1)), 0.004 * diameter)
        for some in np.split(viewpoints, range(several, len(viewpoints), several))
    ]
    return np.concatenate(hidden).reshape(len(viewpoints), len(points))


ALL = slice(None)
LOOSE = 0.10
"""Tolerance of a vote, in projected diameters: what a cell's width and the missing perspective may move a feature."""
