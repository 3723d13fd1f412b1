"""Poses of a type that its views suggest on a plane: place, turn about the plumb line, and the face that it stands on.

* ``stood(photo, camera, body, plane, faces, most)``: the best of them, no two alike

A body that stands has three ways to move, not six. Each face, turned by even steps, is laid over every place of the
photo, in the size that it has there; the best of these climb as those of ``sensing.views.search`` do, and may leave the
plane a little: the plane is known about as well.
"""

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.bodies.resting import Plane, RestingFaces, along_plane
from geometry.camera import Camera
from geometry.frames import least_turns, turn_about
from sensing.views.loops import apart, laid_down
from sensing.views.maps import UNIT, PhotoMaps, TypeMaps
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
STEP = 0.1
"""Share of the size from one place to the next."""
BLOCK = 40.0
"""Pixels of a square of the photo in which one line of sight tells the view."""
SEEDS = 120
"""Places that climb, no two alike."""
KEPT = 4000
"""Of the best places."""
GRAZING = 0.02
"""Cosine to the plumb line of a line of sight along which nobody knows where the plane is."""


def stood(
    photo: PhotoMaps, camera: Camera, body: Body, plane: Plane, faces: RestingFaces, most: int
) -> tuple[Floats, Floats]:
    """Poses (N, 4, 4) of a type on a plane below the camera and their scores (N,), best first, at most ``most``."""
    views, maps = body.views, TypeMaps(photo, body.views)
    seeds = everywhere_on(maps, camera, body, plane, faces)
    turns = turns_of(seeds, views)
    rows = climbing(maps, views, seeds[apart(seeds[:, 2:5], turns, SEEDS, *ALIKE_COARSE)])
    turns = turns_of(rows, views)
    kept = apart(rows[:, 2:5], turns, most, *ALIKE)
    return posed(rows[kept], turns[kept], camera, body), rows[kept, 5]


def everywhere_on(maps: TypeMaps, camera: Camera, body: Body, plane: Plane, faces: RestingFaces) -> Floats:
    """The best of all places on a plane, rows (N, 6) as of ``sensing.views.search.everywhere``, best first."""
    rows = [np.zeros((0, 6))]
    for down, reach in zip(faces.down, faces.reach, strict=True):
        places = _places(camera, body, plane, float(reach - down @ body.middle))
        if len(places):
            which, turned = _seen_from(camera, plane, down, body.views)
            rows += _scored(maps, body.views, places, _blocks(camera, places), which, turned)
    every = np.concatenate(rows)
    return np.asarray(every[np.argsort(-every[:, 5], kind="stable")[:KEPT]])


def _scored(
    maps: TypeMaps, views: Views, places: Floats, block: Ints, which: Ints, turned: Floats
) -> list[Floats]:
    """Rows of the best turn at each of places (P, 3), scale by scale."""
    rows, scales = [], np.array([scale_for(size, COARSE) for size in places[:, 2]])
    for scale in np.unique(scales):
        mine = scales == scale
        stack = maps.stack(float(scale), SPREAD, EVERY)
        some, at = places[mine], block[mine]
        best, turn = laid_down(stack, views, some, at, which, turned, scale / EVERY, POWER)
        rows.append(np.column_stack([which[at, turn], turned[at, turn], some[:, 2], some[:, :2], best / UNIT]))
    return rows


def _places(camera: Camera, body: Body, plane: Plane, high: float) -> Floats:
    """(P, 3) places of the photo where a body's middle may be, ``high`` m above the plane, and its size there."""
    rows, y = [np.zeros((0, 3))], 0.0
    while y < camera.height:
        size = _size(camera, body, plane, high, np.array([[0.5 * camera.width, y]]))[0]
        step = STEP * float(np.clip(np.nan_to_num(size, nan=SIZES[0]), *SIZES[:2]))
        x = np.arange(0.0, camera.width, step)
        at = np.column_stack([x, np.full(len(x), y)])
        size = _size(camera, body, plane, high, at)
        kept = (size >= SIZES[0]) & (size <= SIZES[1])
        rows.append(np.column_stack([at[kept], size[kept]]))
        y += step
    return np.concatenate(rows)


def _size(camera: Camera, body: Body, plane: Plane, high: float, at: Floats) -> Floats:
    """(N,) pixels of the diameter where the middle is seen at places (N, 2); NaN where the plane is not there."""
    sight = np.column_stack([camera.normalised(at), np.ones(len(at))])
    falling = sight @ plane.up
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (high - plane.offset) / falling
        ahead = (np.abs(falling) > GRAZING * np.linalg.norm(sight, axis=1)) & (depth > 0.0)
        return np.where(ahead, camera.f * body.diameter / depth, np.nan)


def _grid(camera: Camera) -> tuple[int, int]:
    return int(np.ceil(camera.width / BLOCK)), int(np.ceil(camera.height / BLOCK))


def _blocks(camera: Camera, places: Floats) -> Ints:
    """(P,) in which square each place is."""
    across = _grid(camera)[0]
    x, y = (places[:, :2] // BLOCK).astype(np.int64).T
    return np.asarray(y * across + x)


def _seen_from(camera: Camera, plane: Plane, down: Floats, views: Views) -> tuple[Ints, Floats]:
    """(B, ``TURNS``) the view that a body which stands so shows in each square, at each turn; and its turn there."""
    across, high = _grid(camera)
    x, y = np.meshgrid((np.arange(across) + 0.5) * BLOCK, (np.arange(high) + 0.5) * BLOCK)
    sight = np.column_stack([camera.normalised(np.column_stack([x.ravel(), y.ravel()])), np.ones(x.size)])
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    upright = _axes(-plane.up) @ _axes(down).T
    about = np.stack([turn_about(plane.up, 2.0 * np.pi * k / TURNS)[:3, :3] @ upright for k in range(TURNS)])
    facing = least_turns(np.array([0.0, 0.0, 1.0]), sight).transpose(0, 2, 1)
    turns = np.einsum("bij,tjk->btik", facing, about)
    which = np.argmax(turns[:, :, 2] @ views.turn[:, 2].T, axis=2)
    rest = np.einsum("btij,btkj->btik", turns, views.turn[which])
    return which, np.arctan2(rest[..., 1, 0] - rest[..., 0, 1], rest[..., 0, 0] + rest[..., 1, 1])


def _axes(normal: Floats) -> Floats:
    """(3, 3) whose columns are a unit vector and two at right angles to it."""
    return np.column_stack([normal, along_plane(normal)])
