"""Painting patches out: the picture as if its walls were bare, so that a window's border is no object's edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.detectors.edges import meet, sample
from sensing.detectors.patches import areas

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RIM = (1.2, 2.2)
"""Least and most pixels by which a patch is painted out beyond its border: 0.3 of its width, within these."""


def without_patches(grey: NDArray[np.float32], corners: Floats) -> NDArray[np.float32]:
    """A copy of the (H, W) picture where each of the (N, 4, 2) patches has the median brightness found just around it."""
    import cv2

    out = grey.copy()
    if not len(corners):
        return out
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    by = np.clip(0.3 * areas(corners) / np.maximum(sides.max(axis=1), 1e-9), *RIM)
    around = np.median(sample(grey, _rim(_grown(corners, by + 0.7))), axis=1)
    for quad, level in zip(_grown(corners, by), around, strict=True):
        cv2.fillConvexPoly(out, np.rint(quad * 16).astype(np.int32), float(level), shift=4)
    return out


def _grown(corners: Floats, by: Floats) -> Floats:
    """Each side moved out by ``by`` (N,) pixels."""
    along = np.roll(corners, -1, axis=1) - corners
    along = along / np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-9)
    out = np.stack([along[:, :, 1], -along[:, :, 0]], axis=2)
    moved = corners + by[:, None, None] * out
    return np.nan_to_num(meet(np.roll(moved, 1, axis=1), np.roll(along, 1, axis=1), moved, along), nan=-1.0)


def _rim(corners: Floats) -> Floats:
    """(N, 12, 2) places: three along each side."""
    following = np.roll(corners, -1, axis=1)
    return np.concatenate([corners * (1 - t) + following * t for t in (0.2, 0.5, 0.8)], axis=1)
