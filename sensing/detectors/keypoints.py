"""Keypoints: places with size, direction and descriptor, by OpenCV's SIFT and ORB (``sift``, ``orb``, or words).

* ``Keypoints``: what an image shows as arrays, ``Keypoints(uv=(N, 2), angle=(N,), scale=(N,), response=(N,),
  descriptors=(N, 128))``

Places are corrected to our convention (an integer is a pixel's centre): SIFT's first, doubled picture is made without
OpenCV's bias of a quarter of a pixel, and what ORB finds in a smaller picture is mapped back between pixels' centres,
not between their corners.

* ``colours(image, uv, angle, scale)``: ten bytes a keypoint, to be put behind its descriptor: what a grey descriptor
  does not see, a red sticker beside a green one
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Mask
from sensing.errors import DetectorError

MOST = 4000
"""Keypoints that one image gives at most, the strongest; those of several directions at one place count each."""
CONTRAST = 0.01
"""SIFT's contrast threshold as OpenCV counts it (divided by the layers of an octave). A quarter of OpenCV's own: an
over-exposed or noisy photo of an object 150 pixels tall has few strong keypoints, and a false weak one costs little
where acceptance rests on agreement."""
FAST_LEVELS = 8.0
"""ORB's contrast threshold: grey levels by which FAST's ring differs from its middle. OpenCV's own is 20; low for the
same reason."""
LAYERS, EDGE, SIGMA = 3, 10.0, 1.6
SHRINK, LEVELS = 1.2, 8
"""ORB's pyramid: each of 8 levels is 1.2 times smaller than the one before."""
LEAST_SIDE = 8
"""An image with a shorter side has no keypoints: no neighbourhood fits into it."""
WIDTHS = {"sift": (128, 138), "orb": (32,)}
"""Bytes that a descriptor may have: SIFT's without colours and with them (``sensing.detectors.keypoints``)."""


@dataclass(frozen=True)
class Keypoints:
    """N keypoints, the strongest first; a place with several directions is there once for each.

    Attributes:
        uv: (N, 2) places in pixels; an integer is a pixel's centre.
        angle: (N,) radians in [0, 2π), clockwise on the screen from +x.
        scale: (N,) diameters in pixels, OpenCV's ``size``.
        response: (N,) strength in the detector's own unit, at least 0: SIFT's contrast, ORB's Harris measure.
        descriptors: (N, 128) uint8 of SIFT or (N, 32) uint8 of ORB.
    """

    uv: Floats
    angle: Floats
    scale: Floats
    response: Floats
    descriptors: Bytes

    def __len__(self) -> int:
        return len(self.uv)

    def chosen(self, which: Mask | NDArray[np.intp]) -> "Keypoints":
        """Those that a mask (N,) or indices (M,) name, in that order."""
        return Keypoints(
            self.uv[which], self.angle[which], self.scale[which], self.response[which], self.descriptors[which]
        )


def keypoints(
    image: Bytes, name: str = "sift", *, contrast: float | None = None, most: int = MOST, where: Mask | None = None
) -> Keypoints:
    """Keypoints of an (H, W) or (H, W, 3) uint8 image, blue first; the same pixels give the same arrays.

    Args:
        image: The pixels. A constant or a tiny image (``LEAST_SIDE``) gives none.
        name: ``sift`` or ``orb``.
        contrast: The threshold in the detector's own unit: ``CONTRAST`` or ``FAST_LEVELS`` where it is None.
        most: How many at most, by response.
        where: (H, W), those of them on whose pixel it holds; SIFT describes no others, which takes most of its time.

    Raises:
        DetectorError: There is no such keypoint detector.
    """
    if name not in WIDTHS:
        raise DetectorError(f"keypoints: {name!r} is neither 'sift' nor 'orb'")
    grey = grey_of(image)
    if min(grey.shape) < LEAST_SIDE or grey.min() == grey.max() or most < 1:
        return _arrays([], None, name, grey.shape)
    finder = _sift(contrast, most) if name == "sift" else _orb(contrast, most)
    mask = (
        None if where is None or name != "sift" else where.astype(np.uint8)
    )  # ORB's mask lets others take their place
    found, descriptors = finder.detectAndCompute(np.ascontiguousarray(grey), mask)
    strongest = _strongest(
        _arrays(found, None if descriptors is None else np.asarray(descriptors, np.uint8), name, grey.shape), most
    )
    return strongest if where is None else strongest.chosen(holds(where, strongest.uv))


def holds(where: Mask, uv: Floats) -> Mask:
    """(N,) whether ``where`` (H, W) holds on the pixels of places (N, 2), of which each is in the image."""
    column, row = np.floor(uv + 0.5).astype(np.intp).T
    height, width = where.shape
    return np.asarray(where[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)])


def grey_of(image: Bytes) -> Bytes:
    """(H, W) uint8 of an (H, W) or (H, W, 3) image, blue first."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8) if image.ndim == 3 else image


def sift_at(grey: Bytes, uv: Floats, angle: Floats, scale: Floats, response: Floats) -> Keypoints:
    """SIFT's descriptors of an (H, W) image at (N, 2) pixels, of angles (radians), diameters (px), responses."""
    if not len(uv):
        return _arrays([], None, "sift", grey.shape)
    rows = zip(uv.tolist(), scale.tolist(), np.degrees(angle % (2 * np.pi)).tolist(), response.tolist(), strict=True)
    places = [cv2.KeyPoint(u, v, size, turn, strength, 0) for (u, v), size, turn, strength in rows]
    found, descriptors = _sift(None, 0).compute(np.ascontiguousarray(grey), places)
    return _arrays(found, np.asarray(descriptors, np.uint8), "sift", grey.shape)


def _sift(contrast: float | None, most: int) -> cv2.SIFT:
    return cv2.SIFT.create(most, LAYERS, CONTRAST if contrast is None else contrast, EDGE, SIGMA, cv2.CV_8U, True)  # noqa: FBT003 (positional in OpenCV 4 and 5)


def _orb(contrast: float | None, most: int) -> cv2.ORB:
    return cv2.ORB.create(most, SHRINK, LEVELS, fastThreshold=round(FAST_LEVELS if contrast is None else contrast))


def _arrays(found: Sequence[cv2.KeyPoint], descriptors: Bytes | None, name: str, shape: tuple[int, ...]) -> Keypoints:
    """OpenCV's keypoints as arrays, angles in radians, places in our convention inside (height, width)."""
    rows = np.array([(*k.pt, k.angle, k.size, k.response, k.octave) for k in found], dtype=np.float64).reshape(-1, 6)
    uv = rows[:, :2] if name == "sift" else _between_centres(rows[:, :2], rows[:, 5], shape)
    height, width = shape[:2]
    uv = np.clip(uv, -0.5, (width - 0.5, height - 0.5))
    angle = np.mod(np.radians(rows[:, 2]), 2 * np.pi)
    described = np.zeros((0, WIDTHS[name][0]), np.uint8) if descriptors is None else descriptors
    return Keypoints(uv, angle, rows[:, 3], np.maximum(rows[:, 4], 0), described)


def _between_centres(pt: Floats, octave: Floats, shape: tuple[int, ...]) -> Floats:
    """ORB's places: pixel x of a level is at (x + ½)·s − ½ of the image.

    s is the true ratio of widths (heights), not 1.2^octave.
    """
    power = SHRINK ** octave[:, None]
    size = np.array([shape[1], shape[0]], dtype=np.float64)
    ratio = size / np.maximum(np.rint(size / power), 1)
    return np.asarray((pt / power + 0.5) * ratio - 0.5)


def _strongest(found: Keypoints, most: int) -> Keypoints:
    """At most ``most`` by response, then v, u, angle and scale.

    Of those with one place and one angle, the first alone.
    """
    order = np.lexsort((found.scale, found.angle, found.uv[:, 0], found.uv[:, 1], -found.response))
    found = found.chosen(order)
    key = np.column_stack([np.round(found.uv, 2), np.round(found.angle, 3)])
    first = np.unique(key, axis=0, return_index=True)[1]
    return found.chosen(np.sort(first)[:most])


CELLS = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
"""Where a keypoint's colour is taken, in its own frame (along its angle, and across): at its place, and at the corners
of a square."""
REACH, BROAD = 0.75, 0.5
"""Of a keypoint's diameter: half the square's side, and the standard deviation of what a cell averages."""
DARK = 16.0
"""Grey levels added to each channel: in the dark, colours are noise."""
GAIN = 64.0
"""Bytes for a factor of e between two channels.

All five cells off by a factor of 2 are then as far apart as two SIFT descriptors of one
thing usually are (about 100): light may tint colours by a fifth at little cost, and what has another colour is not
    alike."""
WIDTH = 2 * len(CELLS)
"""Bytes of a keypoint's colours."""
_LEVELS, _ROW = 6, 8192


def is_grey(image: Bytes) -> bool:
    """Whether an (H, W) or (H, W, 3) image has no colours to tell."""
    return image.ndim == 2 or bool((image[..., 0] == image[..., 1]).all() and (image[..., 1] == image[..., 2]).all())


def colours(image: Bytes, uv: Floats, angle: Floats, scale: Floats) -> Bytes:
    """(N, 10) of N keypoints of an (H, W, 3) image, blue first.

    In each cell how red and how blue it is against green, 128 for neither.

    A ratio of channels does not change with brightness. Args are as ``Keypoints`` has them: pixels, radians, diameters
    in pixels.
    """
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along, across = (REACH * scale[:, None] * CELLS[:, i] for i in (0, 1))
    place = np.stack([uv[:, :1] + cos * along - sin * across, uv[:, 1:] + sin * along + cos * across], axis=2)
    level = np.clip(np.rint(np.log2(np.maximum(BROAD * scale, 1e-6))), 0, _LEVELS - 1).astype(int)
    seen = np.zeros((len(uv), len(CELLS), 3))
    for number, picture in enumerate(_pyramid(image)):
        here = np.flatnonzero(level == number)
        seen[here] = between(picture, place[here].reshape(-1, 2) / 2.0**number).reshape(len(here), len(CELLS), 3)
    return ratios(seen).reshape(len(uv), WIDTH)


def ratios(levels: NDArray[np.floating[Any]]) -> Bytes:
    """(..., 2) how red and how blue colours (..., 3) in grey levels are, blue first, against green."""
    against_green = np.log((levels[..., [2, 0]] + DARK) / (levels[..., 1:2] + DARK))
    return np.clip(np.rint(128.0 + GAIN * against_green), 0, 255).astype(np.uint8)


def _pyramid(image: Bytes) -> list[NDArray[np.float32]]:
    """Each picture half as large as the one before, its pixel i at that one's pixel 2i, and twice as blurred."""
    pictures = [np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), 1.0), np.float32)]
    while len(pictures) < _LEVELS:
        pictures.append(np.asarray(cv2.pyrDown(pictures[-1]), np.float32))
    return pictures


def between(picture: NDArray[np.float32], places: Floats) -> Floats:
    """(N, 3) values of an (H, W, 3) picture at places (N, 2) between pixels; beyond the border those at it."""
    rows = [places[i : i + _ROW].astype(np.float32) for i in range(0, len(places), _ROW)]
    border = cv2.BORDER_REPLICATE
    found = [cv2.remap(picture, row[None], None, cv2.INTER_LINEAR, borderMode=border)[0] for row in rows]  # type: ignore[call-overload]
    return np.concatenate([*found, np.zeros((0, 3))])
