"""RCC-8 of two areas of the image at a tolerance (§3.7): which of the eight ways two images can lie to each other.

| relation     | of a to b, at the tolerance t px                                                                       |
|--------------|--------------------------------------------------------------------------------------------------------|
| DC           | no common interior, and farther than t from each other                                                 |
| EC           | no common interior, and t or less from each other                                                      |
| PO           | a common interior, and each sticks out of the other                                                    |
| TPP, NTPP    | a common interior, a is covered and b sticks out; the boundaries come as near as t (TPP), or not (NTPP) |
| TPPi, NTPPi  | the converses                                                                                          |
| EQ           | a common interior, and each is covered by the other                                                    |

The common interior is what is left of the intersection less a seam of t: what is thinner than 2 t is none. Of two areas
one is covered by the other if no point of it is farther than t from the other. Read from the top each row says what the
rows before it leave open, so exactly one relation holds; each row is the mirror of its converse's, and the areas are
taken in an order of their own, so that R(a, b) is the converse of R(b, a), bit for bit. An area without points is DC
from everything.
"""

from typing import NamedTuple

import numpy as np
import shapely

from geometry.visibility.outline import Area
from geometry.visibility.roc import Rcc8, rcc_converse

_QUARTER = 16  # corners of a quarter of a circle: a widened area falls short of its tolerance by 0.1 % of it at most

_CRACK = 1e-6  # px; an area's boundary that runs to and fro within so much is there by rounding


class Related(NamedTuple):
    """How two areas lie to each other, and the ``interior`` that they share: empty for DC and EC."""

    rcc: Rcc8
    interior: Area


def rcc8(a: Area, b: Area, tolerance: float) -> Rcc8:
    """The one RCC-8 relation of ``a`` to ``b`` at the ``tolerance`` (px)."""
    return related(a, b, tolerance).rcc


def related(a: Area, b: Area, tolerance: float) -> Related:
    """As ``rcc8``, with the common interior less a seam of ``tolerance`` px."""
    if a.is_empty or b.is_empty or _boxes_gap(a, b) > tolerance:
        return Related("DC", shapely.Polygon())
    with np.errstate(
        divide="ignore", invalid="ignore"
    ):  # GEOS divides by the turn of edges that run on straight, and copes
        if b.wkb < a.wkb:
            found = _related(b, a, tolerance)
            return Related(rcc_converse(found.rcc), found.interior)
        return _related(a, b, tolerance)


def _related(a: Area, b: Area, tolerance: float) -> Related:
    common = shapely.intersection(a, b).buffer(-tolerance, join_style="mitre")
    if common.is_empty:
        return Related("EC" if shapely.dwithin(a, b, tolerance) else "DC", common)
    return Related(_of_overlapping(a, b, tolerance), common)


def _of_overlapping(a: Area, b: Area, tolerance: float) -> Rcc8:
    a_covered, b_covered = _covers(b, a, tolerance), _covers(a, b, tolerance)
    if a_covered == b_covered:
        return "EQ" if a_covered else "PO"
    if a_covered:
        return "TPP" if _tangential(a, b, tolerance) else "NTPP"
    return "TPPi" if _tangential(b, a, tolerance) else "NTPPi"


def _tangential(inner: Area, outer: Area, tolerance: float) -> bool:
    """Whether the boundaries come as near as ``tolerance``; a crack in ``outer``, where facets meet but for rounding, is no boundary."""
    if not shapely.dwithin(inner.boundary, outer.boundary, tolerance):
        return False
    return tolerance <= _CRACK or not outer.buffer(_CRACK).covers(inner.buffer(tolerance, quad_segs=_QUARTER))


def _covers(a: Area, b: Area, tolerance: float) -> bool:
    """Whether no point of ``b`` is farther than ``tolerance`` px from ``a``; cheap answers first."""
    if _sticks_out(a.bounds, b.bounds, tolerance):
        return False
    if a.covers(b):
        return True
    corners = shapely.points(shapely.get_coordinates(b))
    return bool(shapely.dwithin(corners, a, tolerance).all() and a.buffer(tolerance, quad_segs=_QUARTER).covers(b))


def _sticks_out(outer: tuple[float, ...], inner: tuple[float, ...], tolerance: float) -> bool:
    """Whether the box ``inner`` sticks out of the box ``outer`` by more than ``tolerance``."""
    low = max(outer[0] - inner[0], outer[1] - inner[1])
    return max(low, inner[2] - outer[2], inner[3] - outer[3]) > tolerance


def _boxes_gap(a: Area, b: Area) -> float:
    """How far the boxes round the two are from each other along x or y, px; below 0 where they overlap."""
    (left_a, top_a, right_a, bottom_a), (left_b, top_b, right_b, bottom_b) = a.bounds, b.bounds
    return float(max(left_a - right_b, left_b - right_a, top_a - bottom_b, top_b - bottom_a))
