"""The volume that A4 is about: a closed surface as it is, one that can be closed repaired, any other refused, and which of these it was.

* ``Mended(surface, done="1 hole filled", refused="")``: ``surface`` closed and outward; None where it is refused, and
  ``refused`` says why
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.bodies.overlap import Solid
from geometry.errors import GeometryError
from geometry.visibility.outline import is_closed
from kb.errors import SurfaceError
from kb.surfaces.limits import LARGEST_HOLE
from kb.surfaces.repair import closed_up, joined_twice
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Mended(NamedTuple):
    """``done``: what was repaired, in words and numbers; '' where nothing had to be."""

    surface: Surface | None
    done: str
    refused: str


def mended(surface: Surface) -> Mended:
    """Holes up to ``LARGEST_HOLE`` of the whole are filled, facets turned outward, and of repeated ones one is kept; its hull never stands in."""
    if surface.closed and surface.volume > 0:
        return _checked(surface, "")
    places, facets, holes, left = closed_up(surface)
    done = [
        (joined_twice(surface.triangles), "repeated facet dropped", "repeated facets dropped"),
        (_turned(surface.triangles, facets), "facet turned over", "facets turned over"),
        (holes, "hole filled", "holes filled"),
    ]
    said = ", ".join(f"{count} {one if count == 1 else more}" for count, one, more in done if count)
    if left:
        return Mended(
            None,
            "",
            f"{left} {'hole is' if left == 1 else 'holes are'} larger than {LARGEST_HOLE:.0%} of it, and may be meant",
        )
    if not is_closed(facets):
        return Mended(None, "", "its facets meet in a way that leaves no inside")
    try:
        return _checked(Surface(places, facets), said)
    except SurfaceError as error:
        return Mended(None, "", str(error))


def _checked(surface: Surface, done: str) -> Mended:
    """As a solid that volumes can be taken of."""
    try:
        Solid(surface.vertices, surface.triangles)
    except GeometryError as error:
        return Mended(None, "", str(error))
    return Mended(surface, done, "")


def _turned(before: NDArray[np.int64], after: NDArray[np.int64]) -> int:
    """How many triangles of the one run the other way round in the other."""
    return len({*_cycles(before[:, ::-1])} & {*_cycles(after)} - {*_cycles(before)})


def _cycles(triangles: NDArray[np.int64]) -> list[tuple[int, int, int]]:
    """Each triangle from its least vertex on."""
    first = triangles.argmin(axis=1)
    rows = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return [(a, b, c) for a, b, c in rows.tolist()]
