"""Pictures drawn for the tests: even sectors that meet at a place, and quadrilaterals on a wall, averaged down."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

FINE = 8


def sectors(arms, levels, place=(80.0, 80.0), size=161, noise=3.0, seed=0, length=None):
    """A picture whose directions from ``place`` between successive ``arms`` (radians, ascending) have ``levels``."""
    turned, away = _around(tuple(place), size)
    angle = np.mod(turned - arms[0], 2 * np.pi)
    bounds = np.mod(np.asarray(arms) - arms[0], 2 * np.pi)
    picture = np.asarray(levels, float)[np.searchsorted(bounds, angle, side="right") - 1]
    if length is not None:
        picture[away > length] = float(np.mean(levels))
    return sensed(picture, size, noise, seed)


@lru_cache(maxsize=2)
def _around(place, size):
    """Direction and distance of each fine pixel from a place."""
    v, u = (np.mgrid[: size * FINE, : size * FINE] + 0.5) / FINE - 0.5
    return np.arctan2(v - place[1], u - place[0]), np.hypot(u - place[0], v - place[1])


def quads(corners, wall=190.0, dark=45.0, size=(200, 160), noise=3.0, seed=0):
    """Dark quadrilaterals (N, 4, 2) on a bright wall of (width, height) pixels."""
    fine = np.full((size[1] * FINE, size[0] * FINE), wall, np.float32)
    for quad in np.asarray(corners, float):
        cv2.fillConvexPoly(fine, np.rint(((quad + 0.5) * FINE - 0.5) * 16).astype(np.int32), dark, shift=4)
    return sensed(fine, size, noise, seed)


def sensed(fine, size, noise, seed):
    size = (size, size) if isinstance(size, int) else size
    picture = cv2.GaussianBlur(
        cv2.resize(np.asarray(fine, np.float32), size, interpolation=cv2.INTER_AREA), (0, 0), 0.4
    )
    grain = np.random.default_rng(seed).normal(0, noise, (size[1], size[0], 3))
    return np.clip(np.rint(picture[:, :, None] + grain), 0, 255).astype(np.uint8)
