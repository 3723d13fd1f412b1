"""Blobs of saturated colour: connected regions of one hue (appearance types ``blob_red`` ... ``blob_magenta``).

Hue and saturation are those of HSV, (max − min) / max: neither changes when all three channels are multiplied by one
gain, as long as none is clipped. A region that touches the image's border is left out, for its middle is not the middle
of what it shows.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from sensing.appearance import Appearance

HUES = {
    "red": (345, 15),
    "orange": (15, 42),
    "yellow": (42, 70),
    "green": (70, 165),
    "cyan": (165, 195),
    "blue": (195, 260),
    "magenta": (260, 345),
}
"""Degrees of hue [from, to) of each colour; together they are the circle."""
TYPES = tuple(f"blob_{name}" for name in HUES)
BLUR = 1.0
"""Pixels (σ) by which the picture is smoothed first: a sensor's noise has hues of its own."""
MIN_SATURATION = 0.45
"""Share of the brightest channel by which the darkest falls short of it."""
MIN_VALUE = 30.0
"""Grey levels of the brightest channel; below, noise decides the hue."""
MIN_AREA = 40
"""Pixels of the smallest blob."""


class ColourBlobDetector:
    """Reports blobs at their centroid with ``scale`` (diameter of an equal disc) and ``score`` (mean saturation)."""

    name = "colour_blob"
    types: tuple[str, ...] = TYPES

    def detect(self, image_bgr: NDArray[np.uint8]) -> list[Appearance]:
        """Blobs of an (H, W, 3) uint8 image."""
        soft = cv2.GaussianBlur(image_bgr.astype(np.float32), (0, 0), BLUR)
        hue, saturation, value = np.moveaxis(np.asarray(cv2.cvtColor(soft, cv2.COLOR_BGR2HSV)), 2, 0)
        coloured = (saturation >= MIN_SATURATION) & (value >= MIN_VALUE)
        return [
            a
            for colour, bounds in HUES.items()
            for a in self._of(f"blob_{colour}", coloured & _between(hue, *bounds), saturation)
        ]

    def _of(self, a_type: str, mask: NDArray[np.bool_], saturation: NDArray[np.float32]) -> list[Appearance]:
        opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        count, labels, stats, centre = cv2.connectedComponentsWithStats(opened, connectivity=4, ltype=cv2.CV_32S)
        left, top, width, height, area = stats.T
        rows, columns = mask.shape
        whole = (left > 0) & (top > 0) & (left + width < columns) & (top + height < rows) & (area >= MIN_AREA)
        whole[0] = False
        mean = np.bincount(labels.ravel(), saturation.ravel().astype(np.float64), count) / np.maximum(area, 1)
        size = 2 * np.sqrt(area / np.pi)
        return [
            Appearance(
                "",
                a_type,
                (float(centre[i, 0]), float(centre[i, 1])),
                self.name,
                None,
                float(size[i]),
                float(min(mean[i], 1)),
            )
            for i in np.flatnonzero(whole)
        ]


def _between(hue: NDArray[np.float32], low: float, high: float) -> NDArray[np.bool_]:
    """Where a hue in degrees lies in [low, high), which may pass over 360."""
    return np.asarray((hue >= low) & (hue < high) if low < high else (hue >= low) | (hue < high))
