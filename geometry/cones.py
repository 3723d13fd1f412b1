"""Cones of directions: an even sample of all of them, and the least cone round some."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

GRAIN = 1e-9


def even_directions(count: int) -> NDArray[np.float64]:
    """Unit directions (count, 3), evenly over the sphere (Fibonacci's spiral): about ``spacing(count)`` apart."""
    index = np.arange(count)
    z = 1 - (2 * index + 1) / count
    turn, radius = index * np.pi * (3 - np.sqrt(5)), np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def spacing(count: int) -> float:
    """How far neighbours of ``even_directions(count)`` are apart, rad."""
    return float(np.sqrt(4 * np.pi / count))


def enclosing_cone(directions: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The axis (3,) and the half-angle, rad, of the least cone round unit ``directions`` (N ≥ 1, 3).

    Exact: a least cone is held by one, two or three of them; the farthest one outside joins the holders until none is.
    """
    held = [0]
    while True:
        axis, cosine = _held_by(directions[held])
        reach = directions @ axis
        farthest = int(reach.argmin())
        if reach[farthest] >= cosine - GRAIN or farthest in held:
            return axis, float(np.arccos(np.clip(min(cosine, reach[farthest]), -1, 1)))
        held.append(farthest)


def _held_by(few: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The least cone round a few directions, by trying every pair and triple: its axis and its half-angle's cosine."""
    axes = [few[0]] + [a + b for a, b in combinations(few, 2)]
    for a, b, c in combinations(few, 3):
        across = np.cross(b - a, c - a)
        axes += [across, -across]
    lengths = np.linalg.norm(axes, axis=1)
    units = np.array(axes)[lengths > GRAIN] / lengths[lengths > GRAIN, None]
    cosines = (units @ few.T).min(axis=1)
    best = int(cosines.argmax())
    return units[best], float(cosines[best])
