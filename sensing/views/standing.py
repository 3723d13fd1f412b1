"""Poses of a type that its views suggest on a plane: place, turn about the plumb line, and the face that it stands on.

* ``stood(maps, camera, body, known, faces, most)``: the best of them, no two alike

A body that stands has three ways to move, not six. Each face, turned by even steps, is laid over every place of the
photo, in the size that it has there; the best of these climb as those of ``sensing.views.search`` do, and may leave the
plane a little: the plane is known about as well.
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints
from geometry.bodies.resting import Plane, RestingFaces, along_plane
from geometry.bodies.standing import Known
from geometry.camera import Camera
from geometry.frames import least_turns, turn_about
from sensing.views.loops import apart, laid_in
from sensing.views.maps import UNIT, TypeMaps
from sensing.views.search import (
    ALIKE,
    ALIKE_COARSE,
    COARSE,
    EVERY,
    POWER,
    SIZES,
    SPREAD,
    Body,
    climbing,
    posed,
    scale_for,
    turns_of,
)
from sensing.views.views import Views

TURNS = 24
"""About the plumb line."""
BLOCK = 40.0
"""Pixels of a square of the photo in which one line of sight tells the view and the size."""
PAD = int(np.ceil(COARSE / EVERY))
"""Cells around a map, that a view may reach into."""
SEEDS = 120
"""Places that climb, no two alike."""
KEPT = 4000
"""Of the best places."""
BETWEEN = 0.35
"""Radians between faces that are laid down: what rolls has more, and climbs from one to the next."""
GRAZING = 0.02
"""Cosine to the plumb line of a line of sight along which nobody knows where the plane is."""


def stood(
    maps: TypeMaps, camera: Camera, body: Body, known: Known, faces: RestingFaces, most: int
) -> tuple[Floats, Floats]:
    """Poses (N, 4, 4) of a type on a plane below the camera and their scores (N,), best first, at most ``most``."""
    views = body.views
    seeds = everywhere_on(maps, camera, body, known, faces)
    turns = turns_of(seeds, views)
    rows = climbing(maps, views, seeds[apart(seeds[:, 2:5], turns, SEEDS, *ALIKE_COARSE)])
    turns = turns_of(rows, views)
    kept = apart(rows[:, 2:5], turns, most, *ALIKE)
    return posed(rows[kept], turns[kept], camera, body), rows[kept, 5]


def everywhere_on(maps: TypeMaps, camera: Camera, body: Body, known: Known, faces: RestingFaces) -> Floats:
    """The best of all squares on a plane, rows (N, 6) as of ``sensing.views.search.everywhere``, best first."""
    rows, corners = [np.zeros((0, 6))], _corners(camera)
    middles, plane = corners + 0.5 * BLOCK, known.plane
    some = spread(faces)
    for down, reach in zip(faces.down[some], faces.reach[some], strict=True):
        size = _size(camera, body, plane, float(reach - down @ body.middle), middles)
        there = (size >= SIZES[0]) & (size <= SIZES[1])
        depth = camera.f * body.diameter / size
        seen = np.column_stack([camera.normalised(middles), np.ones(len(middles))]) * depth[:, None]
        there &= known.over(seen, BLOCK / np.sqrt(2.0) * depth / camera.f)
        which, turned = _seen_from(camera, plane, down, body.views, middles[there])
        scales = np.array([scale_for(one, COARSE) for one in size[there]])
        for scale in np.unique(scales):
            mine = scales == scale
            laid = corners[there][mine], which[mine], turned[mine], size[there][mine]
            rows.append(_laid(maps.stack(float(scale), SPREAD, EVERY, PAD), body.views, float(scale), *laid))
    every = np.concatenate(rows)
    return np.asarray(every[np.argsort(-every[:, 5], kind="stable")[:KEPT]])


def spread(faces: RestingFaces) -> list[int]:
    """Which faces are as far apart as ``BETWEEN``, the first ones."""
    kept: list[int] = []
    for k, down in enumerate(faces.down):
        if (faces.down[kept] @ down < np.cos(BETWEEN)).all():
            kept.append(k)
    return kept


def _laid(
    stack: NDArray[np.int8], views: Views, scale: float, corners: Floats, which: Ints, turned: Floats, size: Floats
) -> Floats:
    """(B · T, 6) rows of the best place in each of B squares of a view that is seen there, at each of T turns."""
    cell = EVERY / scale
    ends = np.concatenate([corners, corners + BLOCK], axis=1) / cell
    cells = np.rint(np.minimum(ends, np.tile(np.array(stack.shape[:0:-1]) - 2 * PAD, 2))).astype(np.int64) + PAD
    cells[:, 2:] = np.maximum(cells[:, 2:], cells[:, :2] + 1)
    best, where = laid_in(stack, views, cells, which, turned, size / cell)
    place = ((where - PAD) * EVERY + EVERY // 2 + 0.5) / scale - 0.5
    sizes = np.broadcast_to(size[:, None], best.shape)
    score = best / UNIT * (sizes / 100.0) ** POWER
    return np.stack([which, turned, sizes, place[..., 0], place[..., 1], score], axis=2).reshape(-1, 6)


def _size(camera: Camera, body: Body, plane: Plane, high: float, at: Floats) -> Floats:
    """(N,) pixels of the diameter where the middle is seen at places (N, 2); NaN where the plane is not there."""
    sight = np.column_stack([camera.normalised(at), np.ones(len(at))])
    falling = sight @ plane.up
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (high - plane.offset) / falling
        ahead = (np.abs(falling) > GRAZING * np.linalg.norm(sight, axis=1)) & (depth > 0.0)
        return np.where(ahead, camera.f * body.diameter / depth, np.nan)


def _corners(camera: Camera) -> Floats:
    """(B, 2) of the squares that the photo is cut into."""
    x, y = np.meshgrid(np.arange(0.0, camera.width, BLOCK), np.arange(0.0, camera.height, BLOCK))
    return np.column_stack([x.ravel(), y.ravel()])


def _seen_from(camera: Camera, plane: Plane, down: Floats, views: Views, places: Floats) -> tuple[Ints, Floats]:
    """(B, ``TURNS``) the view that a body which stands so shows at places (B, 2), at each turn; and its turn there."""
    sight = camera.rays(places)
    upright = _axes(-plane.up) @ _axes(down).T
    about = np.stack([turn_about(plane.up, 2.0 * np.pi * k / TURNS) @ upright for k in range(TURNS)])
    facing = least_turns(np.array([0.0, 0.0, 1.0]), sight).transpose(0, 2, 1)
    turns = np.einsum("bij,tjk->btik", facing, about)
    which = np.argmax(turns[:, :, 2] @ views.turn[:, 2].T, axis=2)
    rest = np.einsum("btij,btkj->btik", turns, views.turn[which])
    return which, np.arctan2(rest[..., 1, 0] - rest[..., 0, 1], rest[..., 0, 0] + rest[..., 1, 1])


def _axes(normal: Floats) -> Floats:
    """(3, 3) whose columns are a unit vector and two at right angles to it."""
    return np.column_stack([normal, along_plane(normal)])
