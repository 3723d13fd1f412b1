"""The views that a type is learned from: directions on a sphere, and what a picture from one of them holds.

* ``View``: one picture of the object alone, with its depth, large; smaller and worse pictures are made of it
  (``variants``)
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera

Variant = tuple[NDArray[np.uint8], NDArray[np.uint8]]
"""(h, w, 3) each: the view under random light, with blur and noise.

Before random spots, and before a calm background.

Before spots no keypoint at the outline comes twice; but a region of one colour, which ends there, would hardly ever
come at all.
"""


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


GAIN, GAMMA = (0.7, 1.4), (0.8, 1.25)
"""Ranges of exposure; what is too bright is cut off at 255."""
BLUR, NOISE = (0.4, 1.1), (2.0, 8.0)
"""Ranges of the blur's and the noise's standard deviation: pixels, grey levels."""
LEVEL, TINT, CLOUDY = (20.0, 235.0), 20.0, 6.0
"""Of a calm background: range of its brightness, standard deviations of its channels about it and of the clouds in it;
grey levels."""


def size_of(view: View, pixels: float) -> tuple[int, int]:
    """Width and height of the picture in which the object's diameter is so many pixels."""
    height, width = view.image.shape[:2]
    return max(1, round(width * pixels / view.pixels)), max(1, round(height * pixels / view.pixels))


def variants(view: View, pixels: float, rng: np.random.Generator, count: int) -> list[Variant]:
    """``count`` variants of the view, all different, in which the object's diameter is ``pixels``."""
    import cv2

    size = size_of(view, pixels)
    whole = np.asarray(cv2.resize(view.image * view.mask[..., None], size, interpolation=cv2.INTER_AREA), np.float32)
    share = np.asarray(cv2.resize(view.mask.astype(np.float32), size, interpolation=cv2.INTER_AREA), np.float32)[
        ..., None
    ]
    even = np.asarray(np.clip(whole / 255.0 / np.maximum(share, 1e-3), 0.0, 1.0), np.float32)
    return [_variant(even, share, rng) for _ in range(count)]


def _variant(even: NDArray[np.float32], share: NDArray[np.float32], rng: np.random.Generator) -> Variant:
    """One of an object's colours (h, w, 3), 0 to 1, that has a share (h, w, 1) of each pixel."""
    import cv2

    size = share.shape[1], share.shape[0]
    own = even ** rng.uniform(*GAMMA) * (255.0 * rng.uniform(*GAIN))
    behind = _spots(size, rng)
    blur, noise = rng.uniform(*BLUR), rng.uniform(*NOISE) * rng.standard_normal((*size[::-1], 3), dtype=np.float32)

    def taken(background: NDArray[np.float32]) -> NDArray[np.uint8]:
        picture = np.clip(share * own + (1.0 - share) * background, 0.0, 255.0)
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), blur)) + noise
        return np.clip(np.rint(picture), 0, 255).astype(np.uint8)

    return taken(behind), taken(_calm(size, rng))


def _calm(size: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(h, w, 3) of nearly one colour, as floors, tables and walls are."""
    import cv2

    (width, height), colour = size, rng.uniform(*LEVEL) + rng.normal(0.0, TINT, 3)
    cloudy = rng.normal(0.0, CLOUDY, (height // 16 + 2, width // 16 + 2, 1)).astype(np.float32)
    clouds = np.asarray(cv2.resize(cloudy, size, interpolation=cv2.INTER_CUBIC), np.float32)
    return np.asarray(np.clip(colour + clouds[..., None], 0.0, 255.0), np.float32)


def _spots(size: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(h, w, 3) coarse and fine spots."""
    import cv2

    (width, height), spots = size, np.zeros((size[1], size[0], 3), np.float32)
    for cell, mean, spread, smooth in ((16, 128.0, 60.0, cv2.INTER_CUBIC), (3, 0.0, 25.0, cv2.INTER_LINEAR)):
        some = rng.normal(mean, spread, (height // cell + 2, width // cell + 2, 3)).astype(np.float32)
        spots += np.asarray(cv2.resize(some, size, interpolation=smooth), np.float32)
    return np.clip(spots, 0.0, 255.0)
