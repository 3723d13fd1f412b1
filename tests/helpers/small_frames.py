"""Frames that are quickly done, and the names of those in the folder that the tests share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

KB = Path(__file__).parents[1] / "run" / "batch" / "kb"
"""A knowledge base that is quickly made ready."""
CAMERA = {"width": 64, "height": 48, "K": [[60, 0, 32], [0, 60, 24], [0, 0, 1]], "dist": []}
NAMES = ["alone.png", "bad.json", "g0.json", "g1.json", "g2.json", "g3.json", "shot/image.png", "torn/image.png"]


def gamma(number: int) -> dict[str, Any]:
    """A Γ of a few corners that are no tower's."""
    rows = [
        {"id": f"a{i}", "type": "l_junction", "uv": [5.0 + 9 * i, 7.0 + number], "detector": "junction"}
        for i in range(number % 3)
    ]
    return {"format": "gamma/1", "camera": CAMERA, "appearances": rows}


def picture(path: Path, first: int = 90) -> None:
    """64 × 48 grey pixels, but for the first."""
    pixels = np.full((48, 64, 3), 90, np.uint8)
    pixels[0, 0] = first
    cv2.imwrite(str(path), pixels)
