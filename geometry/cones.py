"""An even sample of all directions."""

import numpy as np
from numpy.typing import NDArray


def even_directions(count: int) -> NDArray[np.float64]:
    """Unit directions (count, 3), evenly over the sphere (Fibonacci's spiral): about ``spacing(count)`` apart."""
    index = np.arange(count)
    z = 1 - (2 * index + 1) / count
    turn, radius = index * np.pi * (3 - np.sqrt(5)), np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def spacing(count: int) -> float:
    """How far neighbours of ``even_directions(count)`` are apart, rad."""
    return float(np.sqrt(4 * np.pi / count))
