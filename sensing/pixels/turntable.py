"""Pictures of one body alone from all around, evenly lit, as learning a type looks at it.

* ``Turn``: one large picture with its depth, ``Turn(image, mask, depth, camera, pixels=580.0)``
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.frames import inverse, look_at
from sensing.pixels.drawn import Paint
from sensing.simulated.body import TexturedMesh

FINER = 2
"""Pictures are drawn so many times larger than the largest that is needed; a texture is smooth at any size. A view of a
box takes 15 ms (by pybullet, 3 times larger, 60 ms)."""
FAR = 20.0
"""Distances of the viewpoint: how far away nothing is."""
POLAR = 0.95
"""Cosine to the z axis from which on another axis is up in the picture."""


@dataclass(frozen=True, eq=False)
class Turn:
    """One picture of the body before nothing.

    ``image`` (H, W, 3) uint8, blue first; ``mask`` (H, W) where the body is; ``depth`` (H, W) metres along the optical
    axis, far away elsewhere; ``camera``, whose ``world_from_camera`` is body_from_camera; ``pixels``: the body's
    diameter in the picture.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32]
    camera: Camera
    pixels: float


def turned(
    mesh: TexturedMesh, viewpoints: Sequence[NDArray[np.float64]], pixels: float, margin: float, away: float
) -> Iterator[Turn]:
    """One picture a direction (3,) from the middle of the mesh's box.

    ``pixels``: the body's diameter, of which pictures are ``FINER`` times as many; ``margin``: what is left around the
    body, and ``away``: the viewpoint's distance, both in diameters.
    """
    paint = Paint(mesh)
    for direction in viewpoints:
        upward = (0.0, 0.0, 1.0) if abs(direction[2]) < POLAR else (0.0, 1.0, 0.0)
        eye = paint.middle + np.asarray(direction, float) * away * paint.diameter
        yield _taken(paint, look_at(eye, paint.middle, upward), pixels * FINER, margin, away)


def _taken(paint: Paint, camera_from_body: NDArray[np.float64], pixels: float, margin: float, away: float) -> Turn:
    """The body, of a diameter of so many pixels, and the margin."""
    f = pixels * away
    box = paint.box(camera_from_body, np.diag([f, f, 1.0]))
    assert box is not None  # noqa: S101 - the viewpoint is far away
    low = np.ceil(box[0]) - round(margin * pixels)
    width, height = (np.floor(box[1]) + round(margin * pixels) - low).astype(int) + 1
    K = np.array([[f, 0.0, -low[0]], [0.0, f, -low[1]], [0.0, 0.0, 1.0]])
    drawn = paint.drawn(camera_from_body, K, (int(width), int(height)))
    depth = np.where(drawn.mask, drawn.depth, FAR * away * paint.diameter).astype(np.float32)
    camera = Camera(int(width), int(height), K, np.zeros(0), inverse(camera_from_body))
    return Turn(np.rint(drawn.colour).astype(np.uint8), drawn.mask, depth, camera, pixels)
