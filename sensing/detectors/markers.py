"""Printed markers: ArUco and AprilTag, by OpenCV's detector. A marker is one compound feature.

Its middle and its four corners.

Marker 7 of ``aruco_4x4`` is reported as five appearances:

=======================  ==========================  ==========================  ========================
type                     place                       ``angle``                   ``scale``
=======================  ==========================  ==========================  ========================
``aruco_4x4_7``          where the diagonals cross   of its upper edge           the mean side
``aruco_4x4_7_c0``       upper left corner           of the edge to corner 1     its two sides' mean
``aruco_4x4_7_c1``       upper right corner          of the edge to corner 2     its two sides' mean
``aruco_4x4_7_c2``       lower right corner          of the edge to corner 3     its two sides' mean
``aruco_4x4_7_c3``       lower left corner           of the edge to corner 0     its two sides' mean
=======================  ==========================  ==========================  ========================

Upper and lower are those of the marker as ``cv2.aruco.generateImageMarker`` draws it; a corner is the outer corner of
the black border. One dictionary is one detector, so that only those run whose markers a KB knows.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats
from sensing.appearance import Appearance
from sensing.detectors.edges import fitted_quads, meet, sides_of
from sensing.detectors.patches import areas
from sensing.errors import DetectorError

DICTIONARIES = {
    "aruco_4x4": ("DICT_4X4_50", 50),
    "aruco_5x5": ("DICT_5X5_100", 100),
    "aruco_6x6": ("DICT_6X6_250", 250),
    "apriltag_36h11": ("DICT_APRILTAG_36h11", 587),
}
"""OpenCV's name of each dictionary, and how many ids it has."""
LEAST_SIDE = 12
"""An image with a shorter side has no markers: the smallest of 6 × 6 cells needs as many pixels and a rim."""


class MarkerDetector:
    """Reports the markers of one dictionary with their corners, each with ``angle`` and ``scale`` (see the module)."""

    def __init__(self, name: str) -> None:
        """A detector of the dictionary ``name``, a key of ``DICTIONARIES``; raises DetectorError for any other name."""
        if name not in DICTIONARIES:
            raise DetectorError(f"markers: {name!r} is no dictionary ({', '.join(DICTIONARIES)})")
        self.name = name
        ids = range(DICTIONARIES[name][1])
        self.types: tuple[str, ...] = tuple(
            f"{name}_{i}{corner}" for i in ids for corner in ("", "_c0", "_c1", "_c2", "_c3")
        )

    def detect(self, image_bgr: Bytes) -> list[Appearance]:
        """Markers of an (H, W, 3) uint8 image, by id, each followed by its corners 0 to 3."""
        if min(image_bgr.shape[:2]) < LEAST_SIDE:
            return []
        grey = np.asarray(cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY), np.uint8)
        corners, ids, _ = _finder(DICTIONARIES[self.name][0]).detectMarkers(grey)
        numbers = np.zeros(0, int) if ids is None else np.asarray(ids).reshape(-1)
        quads = fitted(grey.astype(np.float32), np.array(corners, dtype=np.float64).reshape(-1, 4, 2))
        order = np.lexsort((quads[:, 0, 0], quads[:, 0, 1], numbers))
        return [a for i in order for a in self._appearances(int(numbers[i]), quads[i])]

    def _appearances(self, number: int, quad: Floats) -> list[Appearance]:
        """A marker's five appearances."""
        a, b, c, d = quad
        middle = meet(a, c - a, b, d - b)
        edges = np.roll(quad, -1, axis=0) - quad
        side = np.hypot(*edges.T)
        angle = np.mod(np.arctan2(edges[:, 1], edges[:, 0]), 2 * np.pi)
        name = f"{self.name}_{number}"
        found = [
            Appearance("", name, (float(middle[0]), float(middle[1])), self.name, float(angle[0]), float(side.mean()))
        ]
        for k, (u, v) in enumerate(quad.tolist()):
            found.append(
                Appearance("", f"{name}_c{k}", (u, v), self.name, float(angle[k]), float(side[k] + side[k - 1]) / 2)
            )
        return found


def fitted(grey: NDArray[np.float32], quads: Floats) -> Floats:
    """(N, 4, 2) corners of dark quadrilaterals, clockwise.

    Where lines meet that are fitted to their sides' steepest change.

    A side is looked at over two thirds of its length and to a tenth of the marker's extent across it (less than a
    border cell of a 6 × 6 marker), then to a sixteenth; corners that stray by more than twice that stay where they are.
    """
    for cells in (10, 16, 16):
        sides = sides_of(quads)
        length = np.maximum(np.hypot(*(sides[:, 2:] - sides[:, :2]).T), 1e-9)
        reach = np.clip(np.repeat(areas(quads), 4) / length / cells, 1.2, 6.0)
        moved, _ = fitted_quads(grey, sides, (0.15, 0.85), 32, reach)
        near = np.linalg.norm(moved - quads, axis=2).max(axis=1) <= 2 * reach.reshape(-1, 4).max(
            axis=1
        )  # never for NaN
        quads = np.where(near[:, None, None], moved, quads)
    return quads


def _finder(dictionary: str) -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary)), parameters)
