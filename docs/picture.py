"""``python docs/picture.py out/demo/picture.png docs/demo.png``.

The demo's picture, small enough for a README (a palette PNG).
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

import struct
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np

WIDTH, COLOURS = 760, 64


def small(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) palette indices and the palette (COLOURS, 3), red first, of a picture (H, W, 3), blue first."""
    height = round(picture.shape[0] * WIDTH / picture.shape[1])
    shrunk = cv2.bilateralFilter(cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA), 5, 18, 3)
    pixels = shrunk.reshape(-1, 3).astype(np.float32)
    stop = (cv2.TERM_CRITERIA_MAX_ITER, 20, 0.0)
    cv2.setRNGSeed(0)
    rare = (
        np.unique((pixels / 24).astype(int), axis=0).astype(np.float32) * 24 + 12
    )  # so that few bright pixels keep their colours
    sample = np.concatenate([pixels[::97], rare])
    palette = cv2.kmeans(sample, COLOURS, None, stop, 1, cv2.KMEANS_PP_CENTERS)[2]
    index = np.linalg.norm(pixels[:, None] - palette[None], axis=2).argmin(axis=1)
    return index.reshape(shrunk.shape[:2]).astype(np.uint8), np.rint(palette[:, ::-1]).astype(np.uint8)


def png(index: np.ndarray, palette: np.ndarray) -> bytes:
    """A palette PNG."""
    height, width = index.shape
    rows = np.hstack([np.zeros((height, 1), np.uint8), index]).tobytes()
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)),
        (b"PLTE", palette.tobytes()),
        (b"IDAT", zlib.compress(rows, 9)),
        (b"IEND", b""),
    ]
    packed = [
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


if __name__ == "__main__":
    source, target = sys.argv[1:]
    picture = cv2.imread(source)
    if picture is None:
        sys.exit(f"{source}: no picture")
    Path(target).write_bytes(png(*small(picture)))
