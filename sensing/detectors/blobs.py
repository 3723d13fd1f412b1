"""Dark blobs: connected regions that stay the same over several brightness thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEP = 12
"""Grey levels between two thresholds."""
MIN_AREA, MAX_SHARE = 9, 0.03
"""Smallest area in pixels, largest as a share of the image."""
MIN_FILL = 0.35
"""Area over the bounding box's: a thin diagonal parallelogram fills less."""


@dataclass(frozen=True)
class Blob:
    """A region darker than ``level``: its (N, 2) outline pixels (u, v), and its area in pixels."""

    outline: NDArray[np.int32]
    area: int
    level: float


def dark_blobs(grey: NDArray[np.uint8]) -> list[Blob]:
    """Blobs of an (H, W) image that live through two thresholds or more, each once, at the middle threshold of its life."""
    levels = np.arange(int(grey.min()) + STEP // 2, int(grey.max()), STEP)
    rows = [_regions(grey, int(level)) for level in levels]
    found = np.concatenate(rows) if rows else np.zeros((0, 8))
    return [blob for members in _lives(found) if (blob := _blob(grey, found[members])) is not None]


def _regions(grey: NDArray[np.uint8], level: int) -> NDArray[np.float64]:
    """(N, 8) rows of regions darker than ``level``: centroid u, v, area, box left, top, width, height, level."""
    import cv2

    mask = (grey < level).view(np.uint8)
    _, _, stats, centre = cv2.connectedComponentsWithStats(mask, connectivity=4, ltype=cv2.CV_32S)
    left, top, width, height, area = stats.T
    inside = (left > 0) & (top > 0) & (left + width < grey.shape[1]) & (top + height < grey.shape[0])
    solid = (area >= MIN_AREA) & (area <= MAX_SHARE * grey.size) & (area >= MIN_FILL * width * height)
    keep = inside & solid & (np.minimum(width, height) >= 2)
    keep[0] = False
    kept: NDArray[np.float64] = np.c_[centre, area, left, top, width, height, np.full(len(area), level)][keep]
    return kept


def _lives(found: NDArray[np.float64]) -> list[list[int]]:
    """Groups of rows that are one region at successive thresholds: like centroids, areas within a factor of 2.5."""
    order = np.argsort(found[:, 7], kind="stable")
    grid: dict[tuple[int, int], list[list[int]]] = {}
    groups: list[list[int]] = []
    for i in order:
        u, v, area = found[i, :3]
        cell = (int(u // 8), int(v // 8))
        near = [g for du in (-1, 0, 1) for dv in (-1, 0, 1) for g in grid.get((cell[0] + du, cell[1] + dv), ())]
        mine = next((g for g in near if _same(found[g[-1]], u, v, area)), None)
        if mine is None:
            groups.append([int(i)])
            grid.setdefault(cell, []).append(groups[-1])
        else:
            mine.append(int(i))
    return [g for g in groups if len(g) >= 2]


def _same(row: NDArray[np.float64], u: float, v: float, area: float) -> bool:
    reach = 0.8 + 0.12 * float(np.sqrt(row[2]))
    return bool(abs(row[0] - u) < reach and abs(row[1] - v) < reach and area < 2.5 * row[2] + 8)


def _blob(grey: NDArray[np.uint8], rows: NDArray[np.float64]) -> Blob | None:
    """The blob at the middle of its life, with the outline of its largest part in its box."""
    import cv2

    _, _, area, left, top, width, height, level = rows[len(rows) // 2]
    x, y = int(left), int(top)
    box = np.ascontiguousarray(grey[y : y + int(height), x : x + int(width)] < level).view(np.uint8)
    outlines = cv2.findContours(box, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[-2]
    outline = max(outlines, key=len).reshape(-1, 2) + np.array([x, y], np.int32)
    return Blob(outline.astype(np.int32), int(area), float(level)) if len(outline) >= 4 else None
