"""Who is above whom, and what stands on what: two bodies compared along the plumb lines that meet both.

Along such a line X is *over* Y where the lowest point of X is no lower than the highest of Y, but for a tolerance (m)
by which poses may be wrong, and the middle of X higher than that of Y. Where each is between parts of the other, a link
in a chain say, neither is over the other.

* ``Body``: a posed surface seen from straight above, see ``body_of``
* ``Columns``: the plumb lines that two bodies share, ``Columns(level=(N, 2), gap=(N,), higher=(N,), flat=(N,))``
* ``Contact``: where a body stands on another, ``Contact(patch=<POLYGON ...>, foot=array([0.2, 0.1]))``
"""

from typing import NamedTuple

import numpy as np
import shapely

from geometry.arrays import Floats, Ints, Mask
from geometry.bodies.resting import along_plane
from geometry.frames import rotate, transform_points
from geometry.visibility.occlusion import PosedSurface, even_grid
from geometry.visibility.outline import Area, drawn_together

STEEP = np.pi / 4
"""Radians from the level up to which a facet carries what stands on it (friction 1); what leans on a steeper one does
not stand on it."""
GRID = 300
"""Plumb lines, about, on an even grid over what two footprints share, besides those at its corners."""
FINE = 1000.0
"""Footprints are drawn in millimetres: what is as fine as nothing when shapes are drawn, is so for pixels."""
_INWARD = 1e-3  # of the way to the middle: how far the line at a corner is drawn inside
_THIN = 1e-9  # m²: footprints that share less only touch


class Body(NamedTuple):
    """``surface`` as posed; ``axes`` (3, 3), rows: two level ones and up; its ``footprint`` along up, m.

    ``low``, ``high`` m; ``mass`` (2,) m,
    the place below the centre of its mass. All along the axes.
    """

    surface: PosedSurface
    axes: Floats
    footprint: Area
    low: float
    high: float
    mass: Floats


class Columns(NamedTuple):
    """``level`` (N, 2) m where the lines are.

    ``gap`` (N,) m from the top of Y to the bottom of X, negative where they interleave; ``higher``
    (N,) whether X's middle is the higher; ``flat`` (N,) whether Y's top is level enough to stand on.
    """

    level: Floats
    gap: Floats
    higher: Mask
    flat: Mask


class Contact(NamedTuple):
    """``patch``: hull of the places where X stands on Y, m, level axes.

    ``foot`` (2,) the place below X's centre of mass.
    """

    patch: Area
    foot: Floats


def level_axes(up: Floats) -> Floats:
    """(3, 3), rows: two level unit vectors at right angles, and `up` (3,), made a unit vector."""
    unit = up / np.linalg.norm(up)
    return np.vstack([along_plane(unit).T, unit])


def body_of(surface: PosedSurface, up: Floats) -> Body:
    """A posed surface where `up` (3,), in the frame that it is posed in, is against gravity."""
    axes = level_axes(up)
    placed = transform_points(surface.camera_from_object, surface.vertices) @ axes.T
    middle = transform_points(surface.camera_from_object, centre_of_mass(surface.vertices, surface.triangles)[None])[0]
    footprint = shapely.transform(drawn_together(FINE * placed[:, :2], surface.triangles), lambda at: at / FINE)
    return Body(surface, axes, footprint, float(placed[:, 2].min()), float(placed[:, 2].max()), (axes @ middle)[:2])


def centre_of_mass(vertices: Floats, triangles: Ints) -> Floats:
    """(3,) m, of a surface (V, 3), (T, 3) that is evenly filled; of one that encloses nothing, of its facets."""
    a, b, c = np.moveaxis(vertices[triangles] - vertices.mean(axis=0), 1, 0)
    volume, area = np.einsum("ti,ti->t", a, np.cross(b, c)) / 6.0, np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    filled = abs(volume.sum()) > 1e-6 * area.sum() ** 1.5
    weight, share = (volume, 4.0) if filled else (area, 3.0)
    return np.asarray(vertices.mean(axis=0) + weight @ (a + b + c) / (share * (weight.sum() or 1.0)))


def columns(x: Body, y: Body) -> Columns:
    """Of two bodies of one up, along the plumb lines that meet both; none where their footprints share no area."""
    level = _places(x.footprint, y.footprint)
    (x_low, x_high, _), (y_low, y_high, steep) = _heights(x, level), _heights(y, level)
    met = np.isfinite(x_low) & np.isfinite(y_low)
    gap, higher = x_low - y_high, x_low + x_high > y_low + y_high
    return Columns(level[met], gap[met], higher[met], (steep <= STEEP)[met])


def above(x: Body, y: Body, tolerance: float) -> bool:
    """Whether X is over Y along some plumb line, but for `tolerance` m, and Y over X along none."""
    over = columns(x, y)
    under = columns(y, x) if (over.higher & (over.gap >= -tolerance)).any() else None
    return under is not None and not (under.higher & (under.gap >= -tolerance)).any()


def stands(x: Body, y: Body, tolerance: float) -> Contact | None:
    """Where X stands on Y: it is above Y, and over a level enough part of Y with no more than `tolerance` m between.

    None where nowhere.
    """
    if not above(x, y, tolerance):
        return None
    shared = columns(x, y)
    touching = shared.higher & shared.flat & (np.abs(shared.gap) <= tolerance)
    if not touching.any():
        return None
    return Contact(shapely.convex_hull(shapely.multipoints(shared.level[touching])), x.mass)


def steady(contacts: list[Contact], tolerance: float) -> bool:
    """Whether X stays: its centre of mass is over the hull of these patches together, but for `tolerance` m."""
    hull = shapely.convex_hull(shapely.union_all([one.patch for one in contacts]))
    return bool(shapely.distance(hull, shapely.Point(contacts[0].foot)) <= tolerance)


def _places(first: Area, second: Area) -> Floats:
    """Level places (N, 2) inside both footprints: near the corners of what they share, and an even grid."""
    (l_a, d_a, r_a, u_a), (l_b, d_b, r_b, u_b) = first.bounds, second.bounds
    if not (max(l_a, l_b) < min(r_a, r_b) and max(d_a, d_b) < min(u_a, u_b)):
        return np.zeros((0, 2))
    pieces = [piece for piece in shapely.get_parts(shapely.intersection(first, second)) if piece.area > _THIN]
    return np.concatenate([_of_piece(piece) for piece in pieces]) if pieces else np.zeros((0, 2))


def _of_piece(piece: Area) -> Floats:
    corners, sure = shapely.get_coordinates(piece), shapely.get_coordinates(shapely.point_on_surface(piece))
    inner = corners + _INWARD * (shapely.get_coordinates(shapely.centroid(piece)) - corners)
    inner = inner[shapely.contains_xy(piece, inner[:, 0], inner[:, 1])]
    return np.concatenate([sure, inner, even_grid(piece, GRID)])


def _heights(body: Body, level: Floats) -> tuple[Floats, Floats, Floats]:
    """Lowest and highest (N,) m of a body along plumb lines, NaN where it is missed, and how steep, rad, its top is."""
    into = body.surface.object_from_camera
    up, margin = rotate(into, body.axes[2:]), body.surface.rays.size
    below, over = (
        np.column_stack([level, np.full(len(level), height)]) @ body.axes
        for height in (body.low - margin, body.high + margin)
    )
    rise = body.surface.rays.first_hit(transform_points(into, below), up)
    fall, facet = body.surface.rays.first_triangle(transform_points(into, over), -up)
    a, b, c = np.moveaxis(body.surface.vertices[body.surface.triangles[facet]], 1, 0)
    normal = np.cross(b - a, c - a)
    lean = np.abs(normal @ up[0]) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    met = np.isfinite(rise) & np.isfinite(fall)
    lowest, highest = body.low - margin + rise, body.high + margin - fall
    return np.where(met, lowest, np.nan), np.where(met, highest, np.nan), np.arccos(np.clip(lean, 0.0, 1.0))
