"""Worse pictures of a view, as cameras take them: smaller, before something, too bright or dark, blurred, noisy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.learning.views import View

GAIN, GAMMA = (0.7, 1.4), (0.8, 1.25)
"""Ranges of exposure; what is too bright is cut off at 255."""
BLUR, NOISE = (0.4, 1.1), (2.0, 8.0)
"""Ranges of the blur's and the noise's standard deviation: pixels, grey levels."""


def side(view: View, pixels: float) -> int:
    """Side of the picture in which the object's diameter is so many pixels."""
    return round(view.image.shape[0] * pixels / view.pixels)


def variant(view: View, pixels: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    """(s, s, 3) uint8: the view, ``pixels`` large, before a random background, under random light, with blur and noise."""
    import cv2

    size = side(view, pixels)
    whole = np.asarray(cv2.resize(view.image * view.mask[..., None], (size, size), interpolation=cv2.INTER_AREA), np.float32)
    share = np.asarray(cv2.resize(view.mask.astype(np.float32), (size, size), interpolation=cv2.INTER_AREA))[..., None]
    own = np.clip(whole / 255.0 / np.maximum(share, 1e-3), 0.0, 1.0) ** rng.uniform(*GAMMA) * (255.0 * rng.uniform(*GAIN))
    picture = np.clip(share * own + (1.0 - share) * _background(size, rng), 0.0, 255.0)
    picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), rng.uniform(*BLUR)))
    picture = picture + rng.uniform(*NOISE) * rng.standard_normal(picture.shape, dtype=np.float32)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _background(size: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Coarse and fine spots, so that no keypoint at the outline comes twice."""
    import cv2

    coarse = rng.normal(128.0, 60.0, (size // 16 + 2, size // 16 + 2, 3)).astype(np.float32)
    fine = rng.normal(0.0, 25.0, (size // 3 + 2, size // 3 + 2, 3)).astype(np.float32)
    spots = cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC) + cv2.resize(fine, (size, size), interpolation=cv2.INTER_LINEAR)
    return np.clip(np.asarray(spots, np.float32), 0.0, 255.0)
