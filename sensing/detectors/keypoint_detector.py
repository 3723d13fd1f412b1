"""Keypoints and points along edges behind the protocol of a detector.

* ``described(image, "sift")``: both as arrays
* ``KeypointDetector("sift")``: with a vocabulary of visual words (``WordIndex``) an appearance's type is the name of
  the word that is nearest to its descriptor, without one it is ``sift`` or ``orb``.

The side of an edge is the edge as seen from one of its two sides, by the colours of that side alone.
What lies beyond the outline of an object changes from place to place; what lies within does not. So an edge gives two
appearances, one a side: each says where the edge runs, on which side of it it speaks for, and of what colour that is,
near the edge and farther in. How bright it is against the other side is told apart: within an object it comes again.
Where along an edge they lie is arbitrary, so points are taken densely, and fairly from all parts of the image: no
textured floor drowns a plain object.

* ``EdgeSides``: N sides as arrays
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Mask
from sensing.appearance import Appearance
from sensing.detectors.keypoints import (
    DARK,
    MOST,
    Keypoints,
    between,
    colours,
    grey_of,
    is_grey,
    keypoints,
    ratios,
    sift_at,
)
from sensing.detectors.regions import MOST as REGIONS
from sensing.detectors.regions import regions


def fairly(uv: Floats, cell: float) -> NDArray[np.intp]:
    """(N,) order of what is at places (N, 2), the best first: by turns the best left and the next cell's best left.

    Cells are ``cell`` pixels wide.

    The cells' turns: the first of every cell of the image, then the second of every one, and so on.
    """
    column, row = np.floor(uv / cell).astype(np.intp).T + 1
    number = row * (column.max(initial=0) + 1) + column
    order = np.argsort(number, kind="stable")
    turn, place = np.empty(len(uv), np.intp), np.empty(len(uv), np.intp)
    turn[order] = np.arange(len(uv)) - np.searchsorted(number[order], number[order])
    place[np.argsort(turn, kind="stable")] = np.arange(len(uv))
    return np.argsort(np.minimum(2 * np.arange(len(uv)), 2 * place + 1), kind="stable")


SMOOTH = 1.0
"""Pixels, standard deviation: noise below this size makes no edge."""
LEAST = 1.5
"""Grey levels a pixel that an edge must rise."""
BORDER = 5
"""Pixels of the image's margin without edges: as far as blur and slope reach."""


@dataclass(frozen=True)
class EdgePoints:
    """``uv`` (N, 2) pixels; ``angle`` (N,) radians of the gradient, from dark to bright, clockwise from +x.

    ``rise`` (N,) grey levels a pixel.
    """

    uv: Floats
    angle: Floats
    rise: Floats


def edge_points(image: Bytes, cell: int, most: int, least: float = LEAST, where: Mask | None = None) -> EdgePoints:
    """The strongest point of an edge in each square cell of an image, ``cell`` pixels wide.

    At most ``most``, the strongest first.

    It rises by more than ``least`` grey levels a pixel. A point is where the gradient is greatest along its own
    direction, to a part of a pixel. Of an image (H, W, 3) the gradient is that of the channel in which it is greatest,
    so that colours of one brightness have an edge between them too. Of all these points, only those on whose pixel
    ``where`` (H, W) holds are looked for.
    """
    from sensing.detectors.edge_loops import ridges

    if min(image.shape[:2]) <= 2 * BORDER:
        return EdgePoints(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    gx, gy = _gradient(image)
    inner = np.zeros(image.shape[:2], bool)
    inner[BORDER:-BORDER, BORDER:-BORDER] = True
    if (
        where is not None
    ):  # with all of every cell that it touches, for the strongest there may be where it does not hold
        inner &= cv2.dilate(where.astype(np.uint8), np.ones((2 * cell - 1, 2 * cell - 1), np.uint8)) > 0
    found = ridges(gx, gy, inner, least, cell)
    if where is not None:
        found = found[where[found[:, 1].astype(int), found[:, 0].astype(int)]]
    found = found[np.lexsort((found[:, 0], found[:, 1], -found[:, 2]))][:most]
    at, here, across, (ahead, behind) = found[:, :2], found[:, 2], found[:, 3:5], found[:, 5:].T
    bend = np.minimum(ahead + behind - 2.0 * here, -1e-6)
    uv = at + np.clip(0.5 * (behind - ahead) / bend, -0.5, 0.5)[:, None] * across
    return EdgePoints(uv, np.arctan2(across[:, 1], across[:, 0]), here)


def _gradient(image: Bytes) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(H, W, C) grey levels a pixel along x and y."""
    smooth = np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), SMOOTH), np.float32)
    shape = (*image.shape[:2], -1)
    gx, gy = (
        np.asarray(cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=0.125), np.float32).reshape(shape)
        for order in ((1, 0), (0, 1))
    )
    return gx, gy


DEPTHS = (2.5, 6.0)
"""Pixels from the edge at which its side's colour is taken: beyond the blur of the edge, and farther in."""
BROAD = 1.5
"""Pixels, standard deviation of what is averaged there."""
WIDTH = 2 * len(DEPTHS) + 1
"""Bytes of a side's looks: its colours, and its brightness against that beyond the edge."""
GAIN = 40.0
"""Bytes for a factor of e between the brightness of the two sides."""
MOST_EDGES = 5000
"""Points of edges, with two sides each, that one image gives at most."""
BLOCK = 32
"""Pixels: half of these are the strongest of each block of the image, in turns, so that no textured floor drowns a
plain object."""
NOISY = 0.75
"""Grey levels a pixel that an edge must rise for each grey level of noise: what noise alone makes rises more in few
cells of 5 pixels."""
_LAPLACE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
_CALM = 8, 0.1
"""Pixels of a cell, and the share of cells that are taken for plain: noise is measured in them."""


@dataclass(frozen=True)
class EdgeSides:
    """N sides, those of the strongest edges first.

    Attributes:
        uv: (N, 2) pixels, on the edge. angle: (N,) radians in [0, 2π), clockwise on the screen from +x, across the edge
        towards this side. rise: (N,) grey levels a pixel by which the edge rises, in the channel in which it rises
        most. looks: (N, 5) how red and how blue the side is against green, near and farther in
        (``sensing.detectors.keypoints.ratios``), and how bright it is near
            the edge against what is beyond, 128 for no difference.
    """

    uv: Floats
    angle: Floats
    rise: Floats
    looks: Bytes

    def __len__(self) -> int:
        return len(self.uv)


def edge_sides(image: Bytes, cell: int, most: int = MOST_EDGES, where: Mask | None = None) -> EdgeSides:
    """Both sides of the strongest edge in each square cell of an (H, W, 3) image, blue first, ``cell`` pixels wide.

    ``most`` edges at most, of those on whose pixel ``where`` (H, W) holds.
    """
    points = edge_points(image, cell, image.size, max(LEAST, NOISY * noise(image)), where)
    chosen = fairly(points.uv, BLOCK)[:most]
    at, rise, across = points.uv[chosen], points.rise[chosen], points.angle[chosen]
    uv = np.repeat(at, 2, axis=0)
    angle = np.mod(np.repeat(across, 2) + np.tile([0.0, np.pi], len(at)), 2.0 * np.pi)
    inward = np.column_stack([np.cos(angle), np.sin(angle)])
    smooth = np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), BROAD), np.float32)
    near, far = (between(smooth, uv + depth * inward) for depth in DEPTHS)
    bright = np.log(near.mean(axis=1) + DARK)
    contrast = bright - bright.reshape(-1, 2)[:, ::-1].ravel()  # a side's other side is the one beside it
    against = np.clip(np.rint(128.0 + GAIN * contrast), 0, 255).astype(np.uint8)
    return EdgeSides(uv, angle, np.repeat(rise, 2), np.column_stack([ratios(near), ratios(far), against]))


def noise(image: Bytes) -> float:
    """Standard deviation of an (H, W, 3) image's noise in its plainest cells, grey levels, in the noisiest channel.

    Immerkaer, Fast Noise Variance Estimation (1996), cell by cell.
    """
    cell, share = _CALM
    if min(image.shape[:2]) < 2 * cell:
        return 0.0
    bent = cv2.blur(np.abs(cv2.filter2D(image.astype(np.float32), -1, _LAPLACE)), (cell, cell))[
        cell // 2 :: cell, cell // 2 :: cell
    ]
    return float(np.sqrt(np.pi / 2.0) / 6.0 * np.quantile(bent.reshape(-1, 3), share, axis=0).max())


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


Like = Callable[[Floats, Floats, Floats], Mask]
"""(N,) which of N points are wanted, of places (N, 2) pixels, angles (N,) radians and diameters (N,) pixels."""


def described(
    image: Bytes,
    name: str = "sift",
    *,
    contrast: float | None = None,
    most: int = MOST,
    cell: int = CELL,
    calm: Bytes | None = None,
    where: Mask | None = None,
    like: Like | None = None,
) -> Keypoints:
    """Keypoints of an (H, W) or (H, W, 3) uint8 image, the strongest first; of ``sift`` edges and regions too.

    At most ``most`` of each; of edges one in each cell of ``cell`` pixels, and at most ``EDGES``. Regions are looked
    for in ``calm``, as large, where it is given. Where the image has colours, they are part of the descriptors of
    ``sift`` (``sensing.detectors.keypoints``). Only what is on a pixel on which ``where`` (H, W) holds is described,
    and of edges only those of which ``like`` holds.

    Raises:
        DetectorError: There is no such keypoint detector.
    """
    blobs = keypoints(image, name, contrast=contrast, most=most, where=where)
    if name != "sift":
        return blobs
    grey = grey_of(image)
    points = edge_points(grey, cell, min(EDGES, most), where=where)
    uv, angle, size, rise = points.uv, points.angle, np.full(len(points.uv), EDGE_SIZE), points.rise
    if like is not None:
        wanted = like(uv, angle, size)
        uv, angle, size, rise = uv[wanted], angle[wanted], size[wanted], rise[wanted]
    edges = sift_at(grey, uv, angle, size, rise * RISE)
    local = joined(blobs, edges)
    if not is_grey(image):
        local = replace(
            local, descriptors=np.column_stack([local.descriptors, colours(image, local.uv, local.angle, local.scale)])
        )
    return joined(local, regions(image if calm is None else calm, min(REGIONS, most), where))


def joined(first: Keypoints, second: Keypoints) -> Keypoints:
    """Both, in this order; their descriptors are of one length."""
    return Keypoints(*(np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(Keypoints)))


class KeypointDetector:
    """Reports keypoints with ``angle``, ``scale``, ``score`` (response over itself plus usual one), ``descriptor``."""

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
