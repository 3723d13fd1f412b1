"""The types of ``plogic bench places``: polyhedra as somebody models them by hand, with places alone and no angles.

* ``places_kb(count, seed)``: Σ of so many types

A body is a stack of rings of corners: prisms, pyramids, frusta, wedges, blocks on blocks, towers with a pointed roof.
Half of the types have regular rings, all of whose corners, and all of whose edges and faces of one storey, look alike;
their symmetries are stated. Of the others every feature looks like any of the vocabulary.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.clutter.types import (
    DIAMETER,
    HALF_ANGLE,
    Detector,
    body_frames,
    knowledge_base,
    made,
    type_names,
)
from geometry.frames import from_rotation_translation
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

LOOKS = 6, 10
"""Least and most appearance types of a knowledge base."""
FEATURES = 14, 40
"""Least and most features of a type: where edges make more, they have none."""
CORNER = np.radians(115.0)
"""Half angle of the lobe of a corner or an edge: it is seen from wherever its body does not hide it."""
SIDES, REGULAR = (3, 6), 0.5
"""Least and most corners of a ring; share of the types whose rings are regular."""
SAME = 1e-6
"""Of the extent, within which a feature is carried onto another."""
PROFILES = (
    ((0.0, 1.0), (1.0, 1.0)),
    ((0.0, 1.0), (1.0, 0.6)),
    ((0.0, 1.0), (1.0, 0.0)),
    ((0.0, 1.0), (0.6, 1.0), (1.2, 0.0)),
    ((0.0, 1.0), (0.5, 1.0), (0.5, 0.6), (1.1, 0.6)),
    ((0.0, 0.7), (0.5, 1.0), (1.0, 0.7)),
)
"""Heights and widths of the rings of a body, both in its greatest radius; a ring of width 0 is one corner."""
DETECTOR = Detector("places", hit=0.85, sigma=1.0, turn=float("nan"))
"""15 % missed, one pixel of noise."""
CLUTTER, OBJECTS = 15.0, 2.5
"""Data of clutter, and objects, that Σ expects in an image."""


class Body(NamedTuple):
    """Corners (V, 3) m by ring, and faces, each the corners of a convex polygon, counter-clockwise from outside.

    ``ring`` (V,): of which ring each corner is; ``storey`` of each face, an even number of a side, odd of a ceiling.
    """

    corners: Floats
    faces: list[list[int]]
    ring: list[int]
    storey: list[int]


def places_kb(count: int, seed: int = 0, looks: tuple[int, int] = LOOKS) -> KnowledgeBase:
    """Σ of so many types, with the statistics of the detector; ``looks``: least and most appearance types."""
    rng = np.random.default_rng([seed, count, *looks])
    names = type_names(int(rng.integers(*looks, endpoint=True)))
    kb = knowledge_base([polyhedron(f"p{i:02d}", names, rng) for i in range(count)], names, DETECTOR)
    rates = replace(
        kb.rates,
        clutter=dict.fromkeys(names, CLUTTER / len(names)),
        prior=dict.fromkeys(kb.rates.prior, OBJECTS / count),
        sigma_angle=None,
    )
    return replace(kb, name="places", rates=rates)


def polyhedron(name: str, names: Sequence[str], rng: np.random.Generator) -> ObjectType:
    """A type: a feature at each corner, in the middle of each face, and of each edge where that is not too many."""
    regular = bool(rng.random() < REGULAR)
    body = stacked(rng, regular=regular)
    at, normal, half_angle, group = _features(body)
    own = group if regular else np.arange(len(at))
    shown = rng.integers(len(names), size=len(at))[own]
    kind = made(name, surface_of(body), at, body_frames(normal, rng), [names[i] for i in shown], half_angle)
    return replace(kind, symmetries=symmetries(at, shown))


def stacked(rng: np.random.Generator, *, regular: bool) -> Body:
    """A body of one of the profiles, standing on its middle, at random as long, wide and high."""
    profile = PROFILES[rng.integers(len(PROFILES))]
    sides = int(rng.integers(SIDES[0], SIDES[1] - (len(profile) > 3), endpoint=True))
    around = 2.0 * np.pi * np.arange(sides) / sides
    if not regular:
        around = around + rng.uniform(-0.3, 0.3, sides) * 2.0 * np.pi / sides
    across = np.ones(2) if regular else rng.uniform(0.6, 1.0, 2)
    way, high = np.column_stack([np.cos(around), np.sin(around)]) * across, rng.uniform(0.8, 2.0)
    corners: list[list[float]] = []
    rings: list[list[int]] = []
    own: list[int] = []
    for level, (height, width) in enumerate(profile):
        number = sides if width else 1
        rings.append(list(range(len(corners), len(corners) + number)))
        corners += [[*(width * way[k]), height * high] for k in range(number)]
        own += [level] * number
    sides_of = [(side, level) for level in range(len(profile) - 1) for side in _sides(rings[level], rings[level + 1])]
    ends = [rings[0][::-1], *([rings[-1]] if len(rings[-1]) > 1 else [])]
    faces = [side for side, _ in sides_of] + ends
    storey = [2 * level for _, level in sides_of] + [1, 3][: len(ends)]
    places = np.array(corners)
    places[:, 2] -= np.ptp(places[:, 2]) / 2.0
    return Body(places * rng.uniform(*DIAMETER) / np.linalg.norm(np.ptp(places, axis=0)), faces, own, storey)


def _sides(low: list[int], high: list[int]) -> list[list[int]]:
    """The faces between two rings."""
    count = len(low)
    return [
        [low[k], low[(k + 1) % count], *([high[(k + 1) % count], high[k]] if len(high) > 1 else high)]
        for k in range(count)
    ]


def surface_of(body: Body) -> Surface:
    """Its triangles, a fan a face."""
    fans = [(face[0], face[k], face[k + 1]) for face in body.faces for k in range(1, len(face) - 1)]
    return Surface(body.corners, np.array(fans))


def _features(body: Body) -> tuple[Floats, Floats, Floats, NDArray[np.intp]]:
    """Places (N, 3), unit normals (N, 3), half angles (N,) of lobes, and groups (N,) of corners, edges and faces.

    Those of a ring or of a storey are of one group.
    """
    normals = np.array([_normal(body.corners[face]) for face in body.faces])
    edges = sorted({(min(e), max(e)) for face in body.faces for e in zip(face, face[1:] + face[:1], strict=True)})
    if len(body.corners) + len(body.faces) + len(edges) >= FEATURES[1]:
        edges = []
    some: list[tuple[tuple[int, ...], int, float]] = [((v,), body.ring[v], CORNER) for v in range(len(body.corners))]
    some += [(edge, 100 + 10 * body.ring[edge[0]] + body.ring[edge[1]], CORNER) for edge in edges]
    rows = [
        (
            body.corners[list(own)].mean(axis=0),
            normals[[set(own) <= set(face) for face in body.faces]].sum(axis=0),
            wide,
            group,
        )
        for own, group, wide in some
    ]
    rows += [
        (body.corners[face].mean(axis=0), normal, HALF_ANGLE, 1000 + storey)
        for face, normal, storey in zip(body.faces, normals, body.storey, strict=True)
    ]
    at, normal, half_angle, group = (np.array(column) for column in zip(*rows, strict=True))
    numbered = np.unique(group, return_inverse=True)[1]
    return at, normal / np.linalg.norm(normal, axis=1, keepdims=True), half_angle, np.asarray(numbered, np.intp)


def _normal(corners: Floats) -> Floats:
    cross = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return np.asarray(cross / np.linalg.norm(cross))


def symmetries(at: Floats, shown: NDArray[np.intp]) -> Floats:
    """(S, 4, 4) the turns about the axis, and half turns across it, that carry each feature (N, 3) onto its like."""
    turns = [np.pi * np.array([0.0, 0.0, 2.0 * k / n]) for n in range(1, SIDES[1] + 1) for k in range(n)]
    across = np.arange(2 * SIDES[1] * 5) * np.pi / (2 * SIDES[1] * 5)
    turns += [np.pi * np.array([np.cos(angle), np.sin(angle), 0.0]) for angle in across]
    found: list[Floats] = []
    for rotation in Rotation.from_rotvec(turns).as_matrix():
        gap = np.linalg.norm((at @ rotation.T)[:, None] - at[None], axis=2) + (shown[:, None] != shown)
        new = all(np.abs(rotation - old).max() > SAME for old in found)
        if new and (gap.min(axis=1) < SAME * float(np.ptp(at, axis=0).max())).all():
            found.append(rotation)
    return from_rotation_translation(np.array(found), np.zeros(3))
