"""How large a scene is, and how near its camera: scenes are made and drawn in units of their own, not in metres.

A scene of bolts is a scene of towers, made smaller: distances, decoys, the gaps between things, the grain of the floor
and the camera's clipping planes all count in one ``unit``. It is a power of two, so that nothing is rounded on the way.

* ``Framing``: ``Framing(unit=0.03125, distance=(3.0, 9.0), reach=(3.0, 9.0), cover=(0.05, 0.6))``
* ``framing_of(largest=0.05, broadest=0.03)``: the framing of a scene whose largest thing is 5 cm
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.camera import Camera
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.surroundings import placed_at

DISTANCE = (3.0, 9.0)
"""Units from the camera to each thing."""
LARGEST, BROADEST = 1.8, 1.5
"""Units: the diagonal of the largest thing's box, and of the broadest one's footprint, in a scene of unit 1."""
COVER = (0.05, 0.6)
"""Least and greatest share of the picture's height that a thing covers."""


@dataclass(frozen=True)
class Framing:
    """``unit``: metres of the scene's unit, in which all else counts.

    ``distance``: from the camera to the middle, at least and at most. ``reach``: the same to each of the shapes, where
    it matters. ``cover``: the share of the picture's height that each shape has, where it matters.
    """

    unit: float = 1.0
    distance: tuple[float, float] = DISTANCE
    reach: tuple[float, float] | None = DISTANCE
    cover: tuple[float, float] | None = None


def framing_of(largest: float, broadest: float) -> Framing:
    """The framing for things of which the largest is so long, m, corner to corner, and the broadest so broad.

    Where the unit comes out as 1 m, a scene has its things in view whole, and no share of the height is asked for.
    """
    size = max(largest / LARGEST, broadest / BROADEST)
    unit = float(2.0 ** round(np.log2(size)))
    return Framing(unit, cover=None if unit == 1.0 else COVER)


def resized(mesh: TexturedMesh, factor: float) -> TexturedMesh:
    """The mesh so many times as large."""
    return mesh if factor == 1.0 else replace(mesh, vertices=mesh.vertices * factor)


def resized_scene(bodies: Sequence[Body], camera: Camera, factor: float) -> tuple[tuple[Body, ...], Camera]:
    """Bodies, and a camera with a pose in the world, with all lengths so many times as long."""
    if factor == 1.0:
        return tuple(bodies), camera
    return tuple(_resized(body, factor) for body in bodies), replace(
        camera, world_from_camera=moved(placed_at(camera), factor)
    )


def _resized(body: Body, factor: float) -> Body:
    return replace(body, mesh=resized(body.mesh, factor), world_from_body=moved(body.world_from_body, factor))


def moved(pose: np.ndarray, factor: float) -> np.ndarray:
    """The pose (4, 4), its translation so many times as long."""
    far = np.array(pose, dtype=np.float64)
    far[:3, 3] *= factor
    return far
