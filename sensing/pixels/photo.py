"""A photo with what is measured of it once: its palette and its noise.

* ``Photo(image, camera)``
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Ints
from geometry.camera import Camera
from sensing.detectors.keypoints import is_grey

COLOURS = 32
"""Of a photo's palette."""
SAMPLES = 6000
"""Pixels that the palette is made of."""
DULL = 0.6
"""How much brightness counts against hue where pixels are put to a colour of the palette."""
_SECOND = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)


DULLED = np.array([DULL, 1.0, 1.0], np.float32)


def lab_of(bgr: NDArray[Any]) -> NDArray[np.float32]:
    """(H, W, 3) CIE L (0 to 100), a, b of colours 0 to 255, blue first."""
    return np.asarray(
        cv2.cvtColor(np.asarray(np.clip(bgr, 0.0, 255.0) / 255.0, np.float32), cv2.COLOR_BGR2LAB), np.float32
    )


def greyed(bgr: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w, 3) of colours (h, w, 3), blue first, what a camera without colours shows."""
    return np.repeat(np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), np.float32)[..., None], 3, axis=2)


LONGEST = 720
"""Pixels of a photo's longer side in which views are looked for: they are 40 to 300 pixels large
(``sensing.views.search``), and things that cover the same share of larger photos are to be found as well. What is small
in a large photo is lost: of ``lmo`` made twice as large 19 are found so, and 23 in all of its 1280 pixels
(``python benchmarks/enlarged.py KB DATASET 2``)."""


@dataclass(frozen=True, eq=False)
class Photo:
    """``image`` (H, W, 3) uint8, blue first, and its camera."""

    image: Bytes
    camera: Camera

    @cached_property
    def small(self) -> "Photo":
        """The same with a longer side of ``LONGEST`` pixels; itself where it has no more."""
        height, width = self.image.shape[:2]
        share = LONGEST / max(height, width)
        if share >= 1.0:
            return self
        size = max(1, round(width * share)), max(1, round(height * share))
        image = np.asarray(cv2.resize(self.image, size, interpolation=cv2.INTER_AREA), np.uint8)
        return Photo(image, self.camera.resized(*size))

    @cached_property
    def grey(self) -> bool:
        """Whether it has no colours to tell, as one of a camera without any."""
        return is_grey(self.image)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of its noise, grey levels (Immerkaer 1996, by the median)."""
        grey = cv2.cvtColor(self.image, cv2.COLOR_BGR2GRAY).astype(np.float32)
        return float(np.median(np.abs(cv2.filter2D(grey, -1, _SECOND))) / 0.6745 / 6.0)

    @cached_property
    def palette(self) -> NDArray[np.float32]:
        """(``COLOURS``, 3) of its own, brightness dulled."""
        every = max(1, round((self.image.shape[0] * self.image.shape[1] / SAMPLES) ** 0.5))
        some = lab_of(self.image[::every, ::every].astype(np.float32)) * DULLED
        return palette_of(some.reshape(-1, 3), COLOURS)


def palette_of(colours: NDArray[np.float32], number: int) -> NDArray[np.float32]:
    """(``number`` or fewer, 3) middles of colours (N, 3), brightness dulled."""
    cv2.setRNGSeed(1)
    which, enough = np.zeros((len(colours), 1), np.int32), (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 8, 0.5)
    some = np.ascontiguousarray(colours)
    return np.asarray(cv2.kmeans(some, min(number, len(some)), which, enough, 1, cv2.KMEANS_PP_CENTERS)[2], np.float32)


def nearest(colours: NDArray[np.float32], palette: NDArray[np.float32]) -> Ints:
    """(N,) which of a palette (C, 3) each of colours (N, 3) is, both dulled."""
    off = (palette**2).sum(axis=1) - 2.0 * colours @ palette.T
    return np.asarray(off.argmin(axis=1), np.int64)


def steepest(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w, 2) slope a pixel, x and y, of the channel of (h, w, C) in which it is steepest."""
    from sensing.pixels.loops import steepest_of  # numba is there in half a second, and only pixels' evidence needs it

    return np.asarray(steepest_of(*(cv2.Scharr(image, cv2.CV_32F, *way) / 32.0 for way in ((1, 0), (0, 1)))))
