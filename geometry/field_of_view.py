"""Focal lengths of ideal cameras, from what people know of theirs.

A field of view is an angle between the outer edges of a picture of `size` (width, height) px, through its middle; an
integer pixel is a pixel's centre, so that the edges lie half a pixel beyond the outermost ones.

* `focal_across(640, 60.0)`: 554.3 px
* `focal_equivalent((4000, 3000), 28.0)`: 3236 px, of a lens that is called 28 mm equivalent
"""

from math import atan, degrees, hypot, radians, tan

DIAGONAL_35MM = hypot(36.0, 24.0)
"""mm; equivalents of 35 mm film are told by the diagonal field of view (CIPA DCG-001), whatever the shape of a
picture."""


def focal_across(side: float, fov: float) -> float:
    """The focal length, px, that sees `fov` degrees, above 0 and below 180, along `side` px."""
    return side / 2.0 / tan(radians(fov) / 2.0)


def fov_across(side: float, f: float) -> float:
    """The degrees that a focal length `f` px, above 0, sees along `side` px."""
    return degrees(2.0 * atan(side / 2.0 / f))


def focal_diagonal(size: tuple[int, int], fov: float) -> float:
    """The focal length, px, that sees `fov` degrees from corner to corner."""
    return focal_across(hypot(*size), fov)


def focal_equivalent(size: tuple[int, int], mm: float) -> float:
    """The focal length, px, of a lens that is called equivalent to `mm` of 35 mm film."""
    return hypot(*size) * mm / DIAGONAL_35MM
