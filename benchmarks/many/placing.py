"""How the objects of ``plogic bench many`` are placed.

None shares volume with another, and of many of them others hide a good part.

* ``Placed``: a type where it stands, with its depth on a coarse grid of pixels
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA, picture, random_pose, surface_of
from geometry.bodies.overlap import solid_overlap
from geometry.visibility.occlusion import PosedSurface
from plogic.match.judged.rivals import solid_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from geometry.bodies.overlap import Solid
    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

OBJECTS, CROWD = (5, 10), (11, 18)
"""Least and most objects of a scene, and of one that is crowded."""
GRID = 4
"""Pixels between the rays by which visible shares are measured: an object's picture has some hundred of them."""
HALF_HIDDEN = 0.4, 0.7
"""Visible shares of what is 30 to 60 % occluded."""
AIMED = 0.6
"""Share of the objects (the first aside) that are placed so that one more is half hidden."""
TRIES = 60
"""Poses among which such a one is sought; the last that shares no volume is taken where there is none."""


@dataclass(frozen=True, eq=False)
class Placed:
    """``depth`` (H, W) m along the rays through every ``GRID``-th pixel, infinite beside the object's picture."""

    kind: ObjectType
    pose: Floats
    depth: Floats


def placed(
    kb: KnowledgeBase, rng: np.random.Generator, number: tuple[int, int] = OBJECTS, aimed: float = AIMED
) -> list[Placed]:
    """So many objects, by least and most, of types drawn alike, several of one type among them by chance.

    ``aimed``: the share that is placed so that one more is half hidden.
    """
    objects: list[Placed] = []
    for _ in range(int(rng.integers(*number, endpoint=True))):
        kind = kb.types[int(rng.integers(len(kb.types)))]
        found = _another(kind, objects, rng, aimed=bool(objects) and bool(rng.random() < aimed))
        objects += [] if found is None else [found]
    return objects


def _another(kind: ObjectType, objects: Sequence[Placed], rng: np.random.Generator, *, aimed: bool) -> Placed | None:
    """One more that shares no volume; where ``aimed``, one by which more objects are half hidden than before.

    None where there is no room.
    """
    before, last = half_hidden(objects), None
    for _ in range(TRIES):
        pose = random_pose(kind, rng)
        if any(meet(kind, pose, other.kind, other.pose) for other in objects):
            continue
        last = Placed(kind, pose, depth_of(kind, pose))
        if not aimed or half_hidden([*objects, last]) > before:
            return last
    return last


def half_hidden(objects: Sequence[Placed]) -> int:
    """How many are 30 to 60 % occluded."""
    shares = visible_shares(objects)
    return int(((shares >= HALF_HIDDEN[0]) & (shares <= HALF_HIDDEN[1])).sum())


def visible_shares(objects: Sequence[Placed]) -> Floats:
    """(N,) of each object's picture as it would be alone the share before which nothing stands."""
    if not objects:
        return np.zeros(0)
    depths = np.stack([one.depth for one in objects])
    nearest = depths.min(axis=0)
    alone = np.isfinite(depths)
    return np.asarray((alone & (depths <= nearest)).sum(axis=(1, 2)) / np.maximum(alone.sum(axis=(1, 2)), 1))


def depth_of(kind: ObjectType, pose: Floats) -> Floats:
    """(H, W) m, as ``Placed`` has it."""
    surface = surface_of(kind)
    columns, rows = np.arange(0, CAMERA.width, GRID), np.arange(0, CAMERA.height, GRID)
    low, high = picture(surface, pose)
    across, down = (columns >= low[0]) & (columns <= high[0]), (rows >= low[1]) & (rows <= high[1])
    uv = np.stack(np.meshgrid(columns[across], rows[down]), axis=-1).reshape(-1, 2).astype(float)
    depth = np.full((len(rows), len(columns)), np.inf)
    posed = PosedSurface(surface.vertices, surface.triangles, surface.rays, pose)
    depth[np.ix_(down, across)] = posed.depth(CAMERA.rays(uv)).reshape(int(down.sum()), int(across.sum()))
    return depth


def meet(kind: ObjectType, pose: Floats, other: ObjectType, at: Floats) -> bool:
    """Whether two types share volume where they stand (A4)."""
    return solid_overlap(body_of(kind), pose, body_of(other), at) > 0.0


def body_of(kind: ObjectType) -> Solid:
    """The body that A4 is about. Raises ValueError for a surface that is none."""
    solid = surface_of(kind).solid
    if solid is None:
        raise ValueError(f"{kind.name} is no solid: {surface_of(kind).mended.refused}")
    return solid_of(solid)
