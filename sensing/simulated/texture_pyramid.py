"""Looking a texture up at any size without aliasing: a pyramid of halved copies, each sample from the one that fits its footprint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

SMALLEST = 16
"""Texels of the smallest copy's shorter side, at least."""
_ROW = 4096
"""Samples a row given to OpenCV, which takes no picture of a million columns."""


class TexturePyramid:
    """A texture (H, W, 3) uint8 with its copies of half the size, and so on; beyond its rims it is mirrored."""

    def __init__(self, texture: NDArray[np.uint8]) -> None:
        """Halve until the shorter side would fall below ``SMALLEST``."""
        import cv2

        self.levels = [np.ascontiguousarray(texture)]
        while min(self.levels[-1].shape[:2]) >= 2 * SMALLEST:
            height, width = self.levels[-1].shape[:2]
            self.levels.append(
                np.asarray(
                    cv2.resize(self.levels[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8
                )
            )

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, texels."""
        return self.levels[0].shape[1], self.levels[0].shape[0]

    def at(self, uv: NDArray[np.float64], footprint: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, 3) colours at ``uv`` (N, 2) in [0, 1], (0, 0) the lower left; ``footprint`` (N,): texels between neighbouring samples."""
        level = np.clip(np.rint(np.log2(np.maximum(footprint, 1e-9))), 0, len(self.levels) - 1).astype(int)
        colours = np.empty((len(uv), 3), np.float32)
        for i, picture in enumerate(self.levels):
            chosen = level == i
            if chosen.any():
                colours[chosen] = _bilinear(picture, uv[chosen])
        return colours


def _bilinear(picture: NDArray[np.uint8], uv: NDArray[np.float64]) -> NDArray[np.float32]:
    import cv2

    height, width = picture.shape[:2]
    at = np.stack([uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5], axis=1).astype(np.float32)
    rows = -(-len(at) // _ROW)
    padded = np.zeros((rows * _ROW, 2), np.float32)
    padded[: len(at)] = at
    grid = padded.reshape(rows, _ROW, 2)
    found = cv2.remap(picture, grid[:, :, 0], grid[:, :, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(found, np.float32).reshape(-1, 3)[: len(at)]
