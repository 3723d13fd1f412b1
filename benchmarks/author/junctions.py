"""How a vertex of a surface looks: the junction that its edges make in the image, and from where.

Vocabulary: ``Region``, the directions from which the same facets are seen, making the same junction, and the least cone
round them. A cuboid's corner has 7: one Y, three arrows, three Ls. What stands in front is not asked here: rays tell.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from geometry.cones import even_directions, spacing
from kb.surfaces.faces import COPLANAR, edge_facets, normals_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.surfaces.surface import Surface

STRAIGHT = 1e-3
"""A gap between arms that differs from π by less is straight, rad."""
SAMPLES = 20_000
RARE = 1e-3
"""Regions with a smaller share of all directions are slivers of the sampling, and left out."""


@dataclass(frozen=True, eq=False)
class Region:
    """``kind`` of junction; the cone's unit ``axis`` (3,), object frame, and ``half_angle`` rad.

    ``share`` of directions.
    """

    kind: str
    axis: NDArray[np.float64]
    half_angle: float
    share: float


def arms(surface: Surface, vertex: int) -> NDArray[np.float64]:
    """Unit directions (K, 3), object frame, of the edges that leave ``vertex``; edges inside a flat face are none."""
    return _arms(surface, vertex)[0]


def junctions(surface: Surface, vertex: int, samples: int = SAMPLES) -> tuple[Region, ...]:
    """The regions of ``vertex``, the largest first; a vertex inside a face or on a straight edge may have none."""
    directions = even_directions(samples)
    seen = facets_seen(surface, vertex, directions)
    kinds = junction_kinds(surface, vertex, directions)
    keys = np.column_stack([seen, np.unique(kinds, return_inverse=True)[1]])
    region = np.unique(keys, axis=0, return_inverse=True)[1]
    found = []
    for label in range(region.max() + 1):
        inside = region.ravel() == label
        if kinds[inside][0] and inside.mean() >= RARE:
            axis, half_angle = enclosing_cone(directions[inside])
            found.append(Region(str(kinds[inside][0]), axis, half_angle + spacing(samples), float(inside.mean())))
    return tuple(sorted(found, key=lambda r: (-round(r.share, 3), r.kind, *np.round(r.axis, 3))))


def facets_seen(surface: Surface, vertex: int, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N, k) which of the k planes that meet at ``vertex`` face a viewpoint in the ``directions`` (N, 3) from it."""
    own = normals_of(surface)[(surface.triangles == vertex).any(axis=1)]
    planes = np.unique(np.round(own, 9), axis=0)
    return np.asarray(directions @ planes.T > 0)


def junction_kinds(surface: Surface, vertex: int, directions: NDArray[np.float64]) -> NDArray[np.str_]:
    """The kind (N,) of junction from each of the ``directions`` (N, 3); '' for fewer than two arms, or two in one line.

    An arm is seen where one of its two facets is. Two arms make an l_junction; three a t_junction with a gap of π, an
    arrow_junction with a larger one, a y_junction with none; four or more a multi_junction.
    """
    lines, sides = _arms(surface, vertex)
    seen = (np.einsum("ni,ksi->nks", directions, sides) > 0).any(axis=2)
    number, beyond = seen.sum(axis=1), widest_gap(lines, seen, directions) - np.pi
    kinds = [
        (number > 3, "multi_junction"),
        ((number == 3) & (np.abs(beyond) <= STRAIGHT), "t_junction"),
        ((number == 3) & (beyond > 0), "arrow_junction"),
        (number == 3, "y_junction"),
        ((number == 2) & (beyond > STRAIGHT), "l_junction"),
    ]
    return np.select([where for where, _ in kinds], [kind for _, kind in kinds], default="")


def widest_gap(
    lines: NDArray[np.float64], seen: NDArray[np.bool_], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The widest angle (N,) rad between neighbours of the arms ``lines`` (K, 3) that are ``seen`` (N, K), in the image.

    The image is the plane across each of the ``directions`` (N, 3); fewer than two arms leave a whole turn.
    """
    right = np.cross(directions, np.eye(3)[np.abs(directions).argmin(axis=1)])
    angles = np.arctan2(np.cross(directions, right) @ lines.T, right @ lines.T)
    turns = np.sort(np.where(seen, angles, np.nan), axis=1)  # those unseen go last
    last = np.nanmax(np.where(seen, angles, -np.inf), axis=1)
    gaps = np.column_stack([np.diff(turns, axis=1), turns[:, 0] + 2 * np.pi - last])
    return np.asarray(np.where(seen.sum(axis=1) > 1, np.nanmax(np.nan_to_num(gaps, nan=0.0), axis=1), 2 * np.pi))


def _arms(surface: Surface, vertex: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit directions (K, 3) of the arms, and the normals (K, 2, 3) of their facets."""
    normals, lines, sides = normals_of(surface), [], []
    for edge, facets in sorted(edge_facets(surface).items()):
        if vertex in edge and np.linalg.norm(normals[facets[0]] - normals[facets[1]]) > COPLANAR:
            lines.append(surface.vertices[sum(edge) - vertex] - surface.vertices[vertex])
            sides.append(normals[facets])
    directions = np.array(lines).reshape(-1, 3)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True), np.array(sides).reshape(-1, 2, 3)


GRAIN = 1e-9
"""Of cosines, below which two are one."""


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
