"""Videos that OpenCV writes, lossless ones (FFV1) among them, and pictures to be told apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

RATE = 10.0
"""Frames a second."""


def pictures(number: int, width: int = 64, height: int = 48) -> list[np.ndarray]:
    """So many noisy pictures (H, W, 3), each its own."""
    rng = np.random.default_rng(number)
    return [rng.integers(0, 256, (height, width, 3)).astype(np.uint8) for _ in range(number)]


def video(path: Path, frames: list[np.ndarray], code: str = "FFV1") -> Path:
    """A video of these frames; FFV1 keeps every pixel."""
    height, width = frames[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*code), RATE, (width, height))
    assert writer.isOpened()
    for frame in frames:
        writer.write(frame)
    writer.release()
    return path


def cut(path: Path, share: float) -> Path:
    """The first part of a file, beside it."""
    data = path.read_bytes()
    out = path.with_name(f"cut_{path.name}")
    out.write_bytes(data[: int(len(data) * share)])
    return out
