"""A mesh as it came to a surface that can be reasoned with: welded, cleaned, closed where it can be, outward, and no larger than needed.

Vocabulary: ``Repaired``, the surface and the numbers of what was done.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.visibility.outline import is_closed
from kb.errors import IntakeError, SurfaceError
from kb.surfaces.holes import filled
from kb.surfaces.orient import turned_outward
from kb.surfaces.simplify import simplified
from kb.surfaces.surface import Surface, welded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Places = NDArray[np.float64]
    Facets = NDArray[np.int64]

FLAPS = 0.05
"""Share of the triangles up to which two back to back are taken for a flap, and beyond it for a sheet's two sides."""


@dataclass(frozen=True, eq=False)
class Repaired:
    """``surface``, m. ``vertices``, ``triangles``: what the source had; ``welded`` vertices that were joined to others; ``dropped``
    triangles that were degenerate or there twice; ``holes`` filled and ``left`` open; ``deviation`` m of the simplified surface.
    """  # noqa: D205 - one object, one sentence

    surface: Surface
    vertices: int
    triangles: int
    welded: int
    dropped: int
    holes: int
    left: int
    deviation: float


def repaired(vertices: Places, triangles: Facets) -> Repaired:
    """The surface of ``vertices`` (V, 3) m and ``triangles`` (T, 3).

    Raises:
        IntakeError: where nothing is left, all the triangles being degenerate.
    """
    try:
        joined = welded(vertices, triangles)
    except SurfaceError as error:
        raise IntakeError(f"no surface can be made of it: {error}") from error
    places, facets, holes, left = closed_up(joined)
    smaller, off = simplified(Surface(places, facets))
    lost = len(triangles) - len(joined.triangles) + joined_twice(joined.triangles)
    return Repaired(
        smaller, len(vertices), len(triangles), len(vertices) - len(joined.vertices), lost, holes, left, off
    )


def closed_up(surface: Surface) -> tuple[Places, Facets, int, int]:
    """Vertices, triangles, holes filled and holes left, of the first way of cleaning that closes the surface; else of the last."""
    result = surface.vertices, surface.triangles, 0, 0
    for single in _once(surface.triangles):
        places, facets, holes, left = filled(surface.vertices, turned_outward(surface.vertices, single))
        result = places, turned_outward(places, facets), holes, left
        if is_closed(result[1]):
            break
    return result


def joined_twice(triangles: Facets) -> int:
    """How many triangles another one repeats."""
    return len(triangles) - len(np.unique(np.sort(triangles, axis=1), axis=0))


def _once(triangles: Facets) -> list[Facets]:
    """Each triangle once, whichever way it faces, in one or two ways.

    Of two triangles back to back, which enclose nothing, neither may be meant: a flap, or the wall between two bodies
    that touch. Or one of them: a sheet drawn from both sides, which takes its vertices with it. The likelier way is the
    last.
    """
    _, first, group, count = np.unique(
        np.sort(triangles, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    facing = np.bincount(group.ravel(), weights=_parity(triangles))
    flap = (count == 2) & (facing == 0)
    one, neither = triangles[np.sort(first)], triangles[np.sort(first[~flap])]
    if not flap.any() or len(np.unique(neither)) < (1 - FLAPS) * len(np.unique(one)):
        return [one]
    return [neither, one] if flap.sum() > FLAPS * len(first) else [one, neither]


def _parity(triangles: Facets) -> NDArray[np.int64]:
    """1 for triangles (T, 3) whose vertices, in order, are an even permutation of ascending ones, else -1."""
    a, b, c = triangles.T
    return np.asarray(np.sign((b - a) * (c - b) * (c - a)))
