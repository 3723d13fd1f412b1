"""Colours about keypoints: what a grey descriptor does not see, a red sticker beside a green one.

* ``colours(image, uv, angle, scale)``: ten bytes a keypoint, to be put behind its descriptor
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats

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
    """(N, 10) of N keypoints of an (H, W, 3) image, blue first: in each cell how red and how blue it is against green, 128 for neither.

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
    """Each picture half as large as the one before, its pixel i where that one's pixel 2i is, and about twice as blurred."""
    import cv2

    pictures = [np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), 1.0), np.float32)]
    while len(pictures) < _LEVELS:
        pictures.append(np.asarray(cv2.pyrDown(pictures[-1]), np.float32))
    return pictures


def between(picture: NDArray[np.float32], places: Floats) -> Floats:
    """(N, 3) values of an (H, W, 3) picture at places (N, 2) between pixels; beyond the border those at it."""
    import cv2

    rows = [places[i : i + _ROW].astype(np.float32) for i in range(0, len(places), _ROW)]
    border = cv2.BORDER_REPLICATE
    found = [cv2.remap(picture, row[None], None, cv2.INTER_LINEAR, borderMode=border)[0] for row in rows]  # type: ignore[call-overload]
    return np.concatenate([*found, np.zeros((0, 3))])
