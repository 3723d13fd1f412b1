"""Keypoints and points along edges behind the protocol of a detector.

* ``described(image, "sift")``: both as arrays
* ``KeypointDetector("sift")``: with a vocabulary of visual words (``WordIndex``) an appearance's type is the name of
  the word that is nearest to its descriptor, without one it is ``sift`` or ``orb``.
"""

from dataclasses import fields, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Mask
from sensing.appearance import Appearance
from sensing.detectors.edge_sides import edge_points, edge_sides
from sensing.detectors.keypoints import MOST, Keypoints, colours, grey_of, is_grey, keypoints, sift_at
from sensing.detectors.regions import MOST as REGIONS
from sensing.detectors.regions import regions

CELL = 5
"""Pixels between points along an edge: half as far from one as it may lie from where another picture has it."""
EDGES = 4000
"""Points along edges that one image gives at most."""
EDGE_SIZE = 4.0
"""Their diameter, pixels: SIFT describes six times as much around them, less than the smallest object that is to be
found."""
RISE = 0.003
"""Their response for one grey level a pixel, in SIFT's unit: both count as half sure at what is typical."""
_HALF = {"sift": 0.015, "orb": 1e-4}
"""The response whose score is one half."""


class WordIndex(Protocol):
    """A vocabulary of visual words, as far as a detector needs it."""

    @property
    def detector(self) -> str:
        """Whose descriptors it holds: ``sift`` or ``orb``."""

    @property
    def names(self) -> tuple[str, ...]:
        """The words' names, which are appearance types."""

    @property
    def sided(self) -> Mask:
        """(W,) which of them are words of the sides of edges."""

    def nearest(self, descriptors: Bytes, /) -> NDArray[np.integer]:
        """(N,) indices into ``names`` of the words nearest to (N, D) descriptors."""

    def nearest_side(self, looks: Bytes, /) -> NDArray[np.integer]:
        """(N,) indices into ``names`` of the words nearest to the (N, 5) looks of sides of edges."""


def described(
    image: Bytes,
    name: str = "sift",
    *,
    contrast: float | None = None,
    most: int = MOST,
    cell: int = CELL,
    calm: Bytes | None = None,
) -> Keypoints:
    """Keypoints of an (H, W) or (H, W, 3) uint8 image and, of ``sift``, points along its edges and then its regions, of each the strongest first.

    At most ``most`` of each; of edges one in each cell of ``cell`` pixels, and at most ``EDGES``. Regions are looked
    for in ``calm``, as large, where it is given. Where the image has colours, they are part of the descriptors of
    ``sift`` (``sensing.detectors.keypoints``).

    Raises:
        DetectorError: There is no such keypoint detector.
    """
    blobs = keypoints(image, name, contrast=contrast, most=most)
    if name != "sift":
        return blobs
    grey = grey_of(image)
    points = edge_points(grey, cell, min(EDGES, most))
    edges = sift_at(grey, points.uv, points.angle, np.full(len(points.uv), EDGE_SIZE), points.rise * RISE)
    local = joined(blobs, edges)
    if not is_grey(image):
        local = replace(
            local, descriptors=np.column_stack([local.descriptors, colours(image, local.uv, local.angle, local.scale)])
        )
    return joined(local, regions(image if calm is None else calm, min(REGIONS, most)))


def joined(first: Keypoints, second: Keypoints) -> Keypoints:
    """Both, in this order; their descriptors are of one length."""
    return Keypoints(*(np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(Keypoints)))


class KeypointDetector:
    """Reports keypoints with ``angle``, ``scale``, ``score`` (response over itself plus a typical one) and ``descriptor``."""

    def __init__(
        self,
        name: Literal["sift", "orb"],
        words: WordIndex | None = None,
        contrast: float | None = None,
        most: int = MOST,
    ) -> None:
        """A detector that names types by ``words``, or by its own name where they are None or another detector's.

        See ``keypoints``.
        """
        self.name: str = name
        self._words = words if words is not None and words.detector == name else None
        self._contrast, self._most = contrast, most
        self.types: tuple[str, ...] = (name,) if self._words is None else tuple(self._words.names)

    def detect(self, image_bgr: Bytes) -> list[Appearance]:
        """``described`` of an (H, W, 3) uint8 image, in that order.

        Then the sides of its edges, where words know any and it has colours.
        """
        found = described(image_bgr, self.name, contrast=self._contrast, most=self._most)
        word = (
            self._words.nearest(found.descriptors)
            if self._words is not None and len(found)
            else np.zeros(len(found), np.intp)
        )
        score = found.response / (found.response + _HALF[self.name])
        columns = zip(
            word,
            found.uv.tolist(),
            found.angle.tolist(),
            found.scale.tolist(),
            score.tolist(),
            found.descriptors,
            strict=True,
        )
        points = [
            Appearance("", self.types[w], (u, v), self.name, a, s, q, descriptor=d.tobytes())
            for w, (u, v), a, s, q, d in columns
        ]
        return points + self._sides(image_bgr)

    def _sides(self, image: Bytes) -> list[Appearance]:
        """The sides of edges: they have no ``scale``, and their ``descriptor`` is their five bytes of looks."""
        if self._words is None or not self._words.sided.any() or is_grey(image):
            return []
        found = edge_sides(image, CELL)
        score = found.rise * RISE / (found.rise * RISE + _HALF[self.name])
        word = self._words.nearest_side(found.looks)
        columns = zip(word, found.uv.tolist(), found.angle.tolist(), score.tolist(), found.looks, strict=True)
        return [
            Appearance("", self.types[w], (u, v), self.name, a, None, q, descriptor=d.tobytes())
            for w, (u, v), a, q, d in columns
        ]
