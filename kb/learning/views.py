"""The views that a type is learned from: directions on a sphere, and what a picture from one of them holds.

* ``View``: one picture of the object alone, with its depth, large; smaller and worse pictures are made of it
  (``variants``)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from geometry.camera import Camera

DIRECTIONS = 80
"""Viewpoints on the sphere: one per 23°, within which SIFT holds."""
PIXELS = (330.0, 230.0, 160.0, 110.0, 75.0)
"""How large the object's diameter is in the pictures, pixels: what cameras see of a thing on a table and a room
away."""
AWAY = 5.0
"""Distance of the viewpoints in diameters of the object."""
MARGIN = 0.125
"""What is left around the object in a picture, in its diameters."""


class View(Protocol):
    """One large picture of the object before nothing, as whoever renders hands it in."""

    @property
    def image(self) -> NDArray[np.uint8]:
        """(H, W, 3), blue first."""

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(H, W) where the object is."""

    @property
    def depth(self) -> NDArray[np.float32]:
        """(H, W) metres along the optical axis where the object is."""

    @property
    def camera(self) -> Camera:
        """Its ``world_from_camera`` is object_from_camera."""

    @property
    def pixels(self) -> float:
        """The object's diameter in this picture, pixels."""


def distance(pixels: float, diameter: float, f: float) -> float:
    """Metres at which an object of a diameter (m) is so many pixels large at the focal length f."""
    return f * diameter / pixels
