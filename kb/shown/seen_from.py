"""From where a type written by hand shows its features: past its own body, and how many of them at once."""

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.cones import even_directions
from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import LobeTable, feature_in_lobe
from kb.surfaces.surface import Surface

MOST_NAMED = 5
"""Features named in one warning; the rest are counted."""
FIXING_A_POSE = 4
"""Features that fix a pose and leave something to check it by."""
TOLERANCE = 0.004
"""What a line of sight may be cut before its feature, as a share of the diameter: the same as for Behind."""
AWAY = 3.0
"""Distance of a viewpoint, in diameters, where the lobes' ranges allow."""
RINGS, AROUND = (0.35, 0.7, 0.99), 6
"""Directions tried in a lobe beside its axis: so many on each of these shares of its half-angle."""
DIRECTIONS, BEST = 200, 40
"""Viewpoints looked from, and how many of the most promising of them are tried with rays."""


def unseen_features(kind: ObjectType) -> list[str]:
    """Names of the features that have lobes and are Behind the type's own surface from all over them."""
    table = kind.lobes
    if not len(table.types):
        return []
    directions = _in_cones(table)
    reach = np.clip(AWAY * size_of(kind), table.r_min, table.r_max)
    viewpoints = table.at[:, None] + reach[:, None, None] * directions
    free = shown(kind, viewpoints.reshape(-1, 3), np.repeat(table.at, directions.shape[1], axis=0))
    seen = np.zeros(table.features, dtype=bool)
    np.logical_or.at(seen, np.repeat(table.feature, directions.shape[1]), free)
    return [kind.seen_features[index].name for index in np.unique(table.feature) if not seen[index]]


def most_together(kind: ObjectType) -> int:
    """The most features, up to ``FIXING_A_POSE``, that were found to share a viewpoint.

    In their lobes and not Behind the type's own surface.
    """
    table = kind.lobes
    if not len(table.types):
        return 0
    viewpoints = _viewpoints(kind, table)
    inside = np.concatenate(
        [feature_in_lobe(table, some, 1.0) for some in np.array_split(viewpoints, max(1, len(viewpoints) // 100))]
    )
    at = np.array([feature.at for feature in kind.seen_features])
    most = 0
    for index in np.argsort(-inside.sum(axis=1), kind="stable")[:BEST]:
        chosen = np.flatnonzero(inside[index])
        if len(chosen) > most:
            seen = shown(kind, np.broadcast_to(viewpoints[index], (len(chosen), 3)), at[chosen]).sum()
            most = max(most, int(seen))
        if most >= FIXING_A_POSE:
            return FIXING_A_POSE
    return most


def _viewpoints(kind: ObjectType, table: LobeTable) -> Floats:
    """Round the type at a few distances, and along some lobes' axes."""
    middle = np.sqrt(np.maximum(table.r_min, 1e-3 * table.r_max) * table.r_max)
    usual = usual_distance(kind)
    distances = np.unique([usual, *np.quantile(middle, [0.1, 0.5, 0.9])])
    centre = kind.surface.centre if kind.surface is not None else table.at.mean(axis=0)
    round_it = [centre + distance * even_directions(DIRECTIONS) for distance in distances]
    some = np.linspace(0, len(middle) - 1, min(len(middle), DIRECTIONS)).astype(int)
    along = table.at[some] + np.clip(usual, table.r_min[some], table.r_max[some])[:, None] * table.axis[some]
    return np.concatenate([*round_it, along])


def usual_distance(kind: ObjectType) -> float:
    """Metres at the reference focal length from which it is looked at, where its features can be seen from there."""
    table = kind.lobes
    return float(np.clip(AWAY * size_of(kind), np.median(table.r_min), np.median(table.r_max)))


def size_of(kind: ObjectType) -> float:
    """The diagonal of the box round its surface, or round its features, m."""
    spread = np.ptp(kind.lobes.at, axis=0) if kind.surface is None else [kind.surface.diameter]
    return float(np.linalg.norm(spread)) or 1.0


def _in_cones(table: LobeTable) -> Floats:
    """Unit directions (L, K, 3): each lobe's axis, and rings round it inside the lobe."""
    half = np.arccos(np.clip(table.cos_half, -1, 1))
    other = np.where(np.abs(table.axis[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(table.axis, other)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(table.axis, u)
    rows = [table.axis]
    for share in RINGS:
        tilt = (share * half)[:, None]
        turns = 2 * np.pi * np.arange(AROUND) / AROUND
        rows += [np.cos(tilt) * table.axis + np.sin(tilt) * (np.cos(turn) * u + np.sin(turn) * v) for turn in turns]
    return np.stack(rows, axis=1)


def shown(kind: ObjectType, viewpoints: Floats, points: Floats) -> Mask:
    """(N,) whether each point is seen from its viewpoint, past the type's own surface.

    From inside of a closed one, nothing is.
    """
    if kind.surface is None or not kind.opaque:
        return np.ones(len(points), dtype=bool)
    lines = points - viewpoints
    hit, triangle = kind.surface.rays.first_triangle(viewpoints, lines)
    free = hit >= np.linalg.norm(lines, axis=1) - TOLERANCE * kind.surface.diameter
    return np.asarray(free & ~_from_inside(kind.surface, triangle, lines))


def _from_inside(surface: Surface, triangle: np.ndarray[tuple[int, ...], np.dtype[np.int64]], lines: Floats) -> Mask:
    """(N,) whether the facet that is hit first is hit on its inner side."""
    if not surface.closed:
        return np.zeros(len(lines), dtype=bool)
    a, b, c = np.moveaxis(surface.vertices[surface.triangles[np.maximum(triangle, 0)]], 1, 0)
    along = np.einsum("ni,ni->n", np.cross(b - a, c - a), lines)
    steep = np.linalg.norm(np.cross(b - a, c - a), axis=1) * np.linalg.norm(lines, axis=1)
    return np.asarray((triangle >= 0) & (along > 1e-6 * steep))


def named(names: list[str]) -> str:
    """The first few names, and how many more there are."""
    more = f" and {len(names) - MOST_NAMED} more features" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more
