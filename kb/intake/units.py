"""Which unit a mesh may be in: no mesh format carries it, so a person says; the bounding box gives a hint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from kb.errors import IntakeError
from kb.quantities import LENGTHS
from kb.surfaces.limits import LARGEST, SMALLEST

if TYPE_CHECKING:
    from numpy.typing import NDArray

ASKED = ("m", "cm", "mm")
"""What is proposed."""
USUAL = 0.25
"""Longest side of the things that people put before a camera, m: the nearest to it, as a ratio, is the likely unit."""


def extent_of(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sides (3,) of the bounding box of vertices (V, 3), in their unit."""
    with np.errstate(over="ignore"):
        return np.asarray(np.ptp(vertices, axis=0))


def likely_unit(longest: float) -> str:
    """The likely unit of a mesh whose longest side has this many units: ``likely_unit(25.8) == "cm"``."""
    return min(ASKED, key=lambda unit: abs(math.log(longest * LENGTHS[unit] / USUAL)))


def proposal(extent: NDArray[np.float64]) -> str:
    """What the mesh's size would be in each unit, and which is likely."""
    longest = float(extent.max())
    sizes = ", ".join(f"{_metres(longest * LENGTHS[unit])} in {unit}" for unit in ASKED)
    box = " x ".join(f"{side:.4g}" for side in extent)
    return f"the mesh measures {box} units, its longest side being {sizes}: probably --units {likely_unit(longest)}"


def _metres(size: float) -> str:
    return f"{size:.3g} m" if size >= 0.1 else f"{size * 1000:.3g} mm"


def check_extent(name: object, extent: NDArray[np.float64], units: str | None) -> None:
    """Hold a mesh's size to the limits.

    Raises:
        IntakeError: no extent at all; no units, with what they may be; a size in these units that no camera sees.
    """
    if not extent.max() > 0 or not np.isfinite(extent).all():
        raise IntakeError(
            f"{name}: has no extent: all vertices are at one place"
            if extent.max() == 0
            else f"{name}: is too large for numbers"
        )
    if units is None:
        raise IntakeError(f"{name}: --units is missing, and no mesh format carries its unit; {proposal(extent)}")
    longest = float(extent.max()) * LENGTHS[units]
    if not SMALLEST <= longest <= LARGEST:
        raise IntakeError(
            f"{name}: would be {longest:.3g} m long in {units}, not {SMALLEST:g} m to {LARGEST:g} m; {proposal(extent)}"
        )
