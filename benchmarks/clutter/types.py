"""The types of ``plogic bench clutter``.

Random clouds on convex bodies, and clouds made of what was learned from meshes.

* ``Detector``: how well features are seen, ``Detector("easy", hit=0.6, sigma=1.0, turn=0.087)``

Every feature has one appearance, seen from a lobe about the z axis of its frame; its x axis is what a datum's angle is
on the screen.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from kb.clouds.lobes import Branch, Lobe, build_tree, features_of
from kb.surfaces.surface import Surface

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from kb.clouds.learned import LearnedCloud

    Floats = NDArray[np.float64]

F_REF = 600.0
APPEARANCES = 1000
"""Data of Γ, nearly all of them clutter."""
DIAMETER = 0.1, 0.3
"""Metres across a random body, least and greatest."""
SQUARE = 2.0, 6.0
"""Exponents of random bodies: 2 is an ellipsoid, 6 nearly a box."""
HALF_ANGLE, LEAST_HALF_ANGLE = np.radians(75.0), np.radians(75.0)
"""Of the lobes of random features, and the least of learned ones, where nothing else is asked for.

Narrower lobes leave the pose open even to somebody who is told the correspondences (the table's row ``told``), and so
do smaller pictures."""
RANGE = 0.05, 20.0
"""Metres from which features are seen: more than any trial needs."""
DIRECTIONS = 40
"""Over which learned features are spread."""
APART = 0.02
"""Least distance of two learned features of a type, as a share of its diameter."""
SLACK = 0.004
"""Share of the diameter within which a surface does not hide its own features, as in the engine."""

DEVIATIONS = 3.0
"""Standard deviations of a place within which a datum may be a feature's: all but one in ninety are."""


@dataclass(frozen=True)
class Detector:
    """``hit``: share of the visible features that it reports.

    ``sigma`` px and ``turn`` radians: the noise of places and of angles.
    """

    name: str
    hit: float
    sigma: float
    turn: float


EASY, HARD = Detector("easy", 0.6, 1.0, float(np.radians(5.0))), Detector("hard", 0.35, 2.0, float(np.radians(12.0)))


def random_types(
    count: int, features: int, appearance_types: int, rng: np.random.Generator, detector: Detector = EASY, appearances: int = APPEARANCES,
    half_angle: float = HALF_ANGLE,
) -> KnowledgeBase:  # fmt: skip
    """``count`` types of so many features each, which look like random ones of ``appearance_types``."""
    names = type_names(appearance_types)
    types = [_random_type(f"r{i:04d}", features, names, rng, half_angle) for i in range(count)]
    return knowledge_base(types, names, detector, appearances)


def type_names(count: int) -> tuple[str, ...]:
    """Names of appearance types: ``a000``, ``a001``, ..."""
    return tuple(f"a{i:03d}" for i in range(count))


def knowledge_base(
    types: Sequence[ObjectType], names: tuple[str, ...], detector: Detector, appearances: int = APPEARANCES
) -> KnowledgeBase:
    """Σ of these types for images of so many appearances, with the detector's statistics learned from such images."""
    rates = Rates(
        hit=dict.fromkeys(names, detector.hit),
        clutter=dict.fromkeys(names, appearances / len(names)),
        prior={kind.name: 1.0 / len(types) for kind in types},
        sigma=detector.sigma,
        match_tolerance=DEVIATIONS * detector.sigma,
        sigma_angle=detector.turn,
    )
    return KnowledgeBase("clutter", tuple(types), names, rates, F_REF, "", _digest(types, rates))


def learned_types(
    kb: KnowledgeBase, features: int, appearance_types: int, least: float = LEAST_HALF_ANGLE
) -> tuple[ObjectType, ...]:
    """Of each learned type one like a type written by hand, of up to ``features`` of its keypoints.

    The surest, spread over the directions of view.

    A feature's z axis is the lobe's, its x axis the keypoint's direction; its appearance type is that of its visual
    word, modulo their number.
    """
    names = type_names(appearance_types)
    return tuple(
        _of_learned(kind, kind.learned.keypoints, features, names, least)
        for kind in kb.types
        if kind.learned is not None
    )


def with_learned(
    kb: KnowledgeBase, learned: Sequence[ObjectType], detector: Detector, appearances: int = APPEARANCES
) -> KnowledgeBase:
    """The learned types, and as many of the random ones as make up the number."""
    types = (*learned, *kb.types)[: max(len(kb.types), len(learned))]
    return knowledge_base(types, kb.appearance_types, detector, appearances)


def _random_type(
    name: str, features: int, names: tuple[str, ...], rng: np.random.Generator, half_angle: float
) -> ObjectType:
    surface = random_body(rng)
    at, normal = scattered(surface, features, rng)
    frames = body_frames(normal, rng)
    looks = [names[i] for i in rng.integers(len(names), size=features)]
    return made(name, surface, at, frames, looks, np.full(features, half_angle))


def random_body(rng: np.random.Generator) -> Surface:
    """A convex body between an ellipsoid and a box, closed, about the origin."""
    import trimesh

    unit = np.asarray(trimesh.creation.icosphere(subdivisions=2).vertices)
    axes, square = rng.uniform(0.5, 1.0, 3), rng.uniform(*SQUARE)
    points = unit / (np.abs(unit / axes) ** square).sum(axis=1, keepdims=True) ** (1.0 / square)
    points *= rng.uniform(*DIAMETER) / (2.0 * np.linalg.norm(points, axis=1).max())
    hull = trimesh.convex.convex_hull(points)
    return Surface(np.asarray(hull.vertices), np.asarray(hull.faces))


def scattered(surface: Surface, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Places (N, 3) spread evenly over the surface, and its unit outward normals (N, 3) there."""
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    facet = rng.choice(len(area), count, p=area / area.sum())
    share = rng.dirichlet(np.ones(3), count)
    at = share[:, :1] * a[facet] + share[:, 1:2] * b[facet] + share[:, 2:] * c[facet]
    return at, cross[facet] / area[facet, None]


def body_frames(normal: Floats, rng: np.random.Generator) -> Floats:
    """object_from_feature (N, 3, 3), the z axes along unit ``normal`` (N, 3), the x axes at random about them."""
    return np.array([_frame(z, rng.normal(size=3)) for z in normal]).reshape(-1, 3, 3)


def _frame(z: Floats, towards: Floats) -> Floats:
    """object_from_feature (3, 3) of unit ``z``, its x axis as near to ``towards`` as it can be."""
    x = towards - (towards @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def made(
    name: str, surface: Surface | None, at: Floats, frames: Floats, looks: Sequence[str], half_angle: Floats
) -> ObjectType:
    """A type of N features: places (N, 3), object_from_feature (N, 3, 3), appearance types, half angles (N,) of lobes.

    What a feature looks like is its own type as well.
    """
    axis = np.array([0.0, 0.0, 1.0])
    lobes = [Lobe(axis, float(angle), *RANGE) for angle in half_angle]
    parts = [
        Branch("feature", f"f{i:03d}", look, place, frame, [Branch("appearance", "", look, lobe=lobe)])
        for i, (place, frame, look, lobe) in enumerate(zip(at, frames, looks, lobes, strict=True))
    ]
    tree = build_tree(Branch("object", name, name, parts=parts))
    features, _ = features_of(tree)
    return ObjectType(name, tree, features, features, surface, opaque=True, symmetries=np.eye(4)[None])


def _of_learned(
    kind: ObjectType, cloud: LearnedCloud, features: int, names: tuple[str, ...], least: float
) -> ObjectType:
    lobes = np.array(list(islice(_spread(cloud, kind.surface), features)), np.intp)
    frames = np.array(
        [_frame(cloud.axis[lobe] / np.linalg.norm(cloud.axis[lobe]), cloud.up[lobe]) for lobe in lobes]
    ).reshape(-1, 3, 3)
    looks = [names[word % len(names)] for word in cloud.lobe_word[lobes]]
    return made(
        kind.name,
        kind.surface,
        cloud.at[cloud.feature[lobes]],
        frames,
        looks,
        np.maximum(cloud.half_angle[lobes], least),
    )


def _spread(cloud: LearnedCloud, surface: Surface | None) -> Iterator[int]:
    """Lobes, one a feature: the surest of each direction, then the second of each, and so on.

    No two at one place, none that is always hidden.
    """
    size = float(np.linalg.norm(np.ptp(cloud.at, axis=0))) if surface is None else surface.diameter
    taken = np.zeros((0, 3))
    for lobe in _by_turns(cloud):
        place = cloud.at[cloud.feature[lobe]]
        near = (np.linalg.norm(taken - place, axis=1) < APART * size).any()
        if not near and (
            surface is None
            or not surface.rays.blocks(place + 2.0 * size * cloud.axis[lobe], place[None], SLACK * size)[0]
        ):
            taken = np.vstack([taken, place])
            yield lobe


def _by_turns(cloud: LearnedCloud) -> list[int]:
    """Each feature's surest lobe, one of each direction in turn, the surest first, of equally sure ones the wider."""
    order = np.lexsort((-cloud.half_angle, -cloud.hit))
    first = order[np.sort(np.unique(cloud.feature[order], return_index=True)[1])]
    direction = (cloud.axis[first] @ _directions().T).argmax(axis=1)
    turn = np.zeros(len(first), np.intp)
    for which in range(DIRECTIONS):
        mine = direction == which
        turn[mine] = np.arange(mine.sum())
    return [int(lobe) for lobe in first[np.argsort(turn, kind="stable")]]


def _directions() -> Floats:
    """(N, 3) unit, spread evenly."""
    z = 1.0 - (2.0 * np.arange(DIRECTIONS) + 1.0) / DIRECTIONS
    around, r = np.pi * (1.0 + 5.0**0.5) * np.arange(DIRECTIONS), np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(around), r * np.sin(around), z], axis=1)


def _digest(types: Sequence[ObjectType], rates: Rates) -> str:
    """SHA-256 over all that a folder of these types would hold."""
    total = hashlib.sha256(repr(rates).encode())
    for kind in types:
        table = kind.lobes
        total.update(repr((kind.name, table.types)).encode())
        frames = np.array([feature.rotation for feature in kind.features])
        arrays = [table.at, table.axis, table.cos_half, frames]
        for array in arrays if kind.surface is None else [*arrays, kind.surface.vertices, kind.surface.triangles]:
            total.update(array.tobytes())
    return total.hexdigest()
