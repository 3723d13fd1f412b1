"""What in a knowledge base is no mistake and yet matters: what will never be found, or be found where it is not.

``LearnedSummary``: a learned type in a few lines, how much there is of it, how surely it is seen, and from where enough
of it is expected.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.cones import even_directions
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.lobes import LobeTable, feature_in_lobe, in_lobe
from kb.surfaces.surface import Surface

MANY = 20
"""Expected features with which a type is found though most of them are missed."""
AT_A_TIME = 20
"""Viewpoints all around, of ``DIRECTIONS``, that are tried at a time."""


@dataclass(frozen=True)
class LearnedSummary:
    """``features``: ``keypoints`` and ``sides`` of edges; ``words``: different visual words of its appearances.

    ``hit`` and ``sigma`` (m): medians.

    ``distance`` (m at the reference focal length): where it is looked at from all around; ``share`` of these viewpoints
    expects at least ``MANY`` features; ``most``: how many the best of them expects. ``compounds``: of ``joined``
    features in all, ``largest`` of them in one.
    """

    detector: str
    features: int
    appearances: int
    words: int
    hit: float
    sigma: float
    distance: float
    share: float
    most: int
    keypoints: int
    sides: int
    compounds: int = 0
    joined: int = 0
    largest: int = 0

    @property
    def lines(self) -> tuple[str, str]:
        """For people."""
        what = (
            f"{self.keypoints} keypoints and {self.sides} sides of edges" if self.sides else f"{self.features} features"
        )
        what += f", {self.joined} of them in {compounds_text(self.compounds, self.largest)}" if self.compounds else ""
        first = f"learned with {self.detector}: {what}, {self.appearances} appearances, {self.words} visual words"
        sure = f"hit rate {self.hit:.2f} and sigma {1000.0 * self.sigma:.2g} mm (medians)"
        seen = (
            f"{MANY} or more features are expected from {self.share:.0%} of the view sphere, {self.distance:.2g} m away"
        )
        return first, f"{sure}; {seen}"


def compounds_text(count: int, largest: int) -> str:
    """How many compound features there are, and of how many parts."""
    return f"{count} compound{'' if count == 1 else 's'} of 2{f' to {largest}' if largest > 2 else ''}"


def compound_sizes(cloud: LearnedCloud) -> tuple[int, int, int]:
    """The number of compound features, of features in them, and of the parts of the largest."""
    sizes = np.bincount(cloud.compound)[1:]
    return len(sizes), int(sizes.sum()), int(sizes.max(initial=0))


def learned_summary(kind: ObjectType) -> LearnedSummary:
    """Of a type that has a learned cloud."""
    cloud = kind.learned
    assert cloud is not None  # noqa: S101 - the caller looks
    if not len(cloud.feature):
        return LearnedSummary(cloud.detector, len(cloud.at), 0, 0, 0.0, 0.0, 0.0, 0.0, 0, len(cloud.at), 0)
    distance = float(np.median(np.sqrt(np.maximum(cloud.r_min, 1e-3 * cloud.r_max) * cloud.r_max)))
    expected = _expected(kind, distance)
    sides = len(np.unique(cloud.feature[cloud.sided]))
    return LearnedSummary(
        cloud.detector,
        len(cloud.at),
        len(cloud.feature),
        len(np.unique(cloud.lobe_word)),
        float(np.median(cloud.hit)),
        float(np.median(cloud.sigma)),
        distance,
        float((expected >= MANY).mean()),
        int(expected.max()),
        len(cloud.at) - sides,
        sides,
        *compound_sizes(cloud),
    )


def _expected(kind: ObjectType, distance: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """(DIRECTIONS,) features with a lobe that holds the viewpoint.

    Lobes were measured on the whole object, so it hides nothing more.
    """
    table = kind.lobes
    centre = kind.surface.centre if kind.surface is not None else table.at.mean(axis=0)
    viewpoints = centre + distance * even_directions(DIRECTIONS)
    counts = []
    for start in range(0, DIRECTIONS, AT_A_TIME):
        held = in_lobe(table, viewpoints[start : start + AT_A_TIME], 1.0)
        counts += [len(np.unique(table.feature[row])) for row in held]
    return np.array(counts)


MOST_NAMED = 5
"""Features named in one warning; the rest are counted."""
MOST_TYPES = 60
"""Types that are compared with each other."""


def cautions(kb: KnowledgeBase) -> Iterator[str]:
    """A sentence about each, the KB's own first, then by type."""
    sorts = {feature.type for kind in kb.types for feature in kind.all_features}
    if len(sorts) == 1:
        yield f"every feature is of type {sorts.pop()!r}, so that every dv is 0 and ev is undefined: nothing will be accepted"
    for kind in kb.types:
        yield from (f"{kind.name}: {text}" for text in _of_type(kind))
    yield from _contained(tuple(kind for kind in kb.types if kind.learned is None)[:MOST_TYPES])
    yield from _same_clouds([kind for kind in kb.types if kind.learned is not None])


def _of_type(kind: ObjectType) -> Iterator[str]:
    yield from _of_mesh(kind)
    if not kind.features:
        yield "has no features, so it is never found; learn them: plogic kb learn"
        return
    if kind.learned is not None:
        yield from _of_learned(kind)
        return
    unseen = unseen_features(kind)
    if unseen:
        yield f"no viewpoint sees {_named(unseen)}: the lobes lie inside or behind the type's own body"
    together = most_together(kind)
    if len(kind.seen_features) < FIXING_A_POSE:
        yield f"has {len(kind.seen_features)} features, and a pose is taken from {FIXING_A_POSE}: it is never found"
    elif together < FIXING_A_POSE and len(unseen) < len(kind.seen_features):
        yield f"its lobes never meet: no viewpoint was found that sees {FIXING_A_POSE} features at once ({together} at most), so it is never found"


def _of_learned(kind: ObjectType) -> Iterator[str]:
    """Its lobes were measured, so that each is seen from somewhere; but there may be too few."""
    summary = learned_summary(kind)
    if summary.most < FIXING_A_POSE:
        yield f"no viewpoint expects {FIXING_A_POSE} of its learned features at once ({summary.most} at most), so it is never found"
    elif summary.most < MANY:
        yield f"no viewpoint expects {MANY} of its learned features at once ({summary.most} at most): it will seldom be found; its texture is plain"


def _of_mesh(kind: ObjectType) -> Iterator[str]:
    if kind.surface is not None and kind.surface.caution:
        yield kind.surface.caution


def _named(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMED} more features" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more


def _contained(types: tuple[ObjectType, ...]) -> Iterator[str]:
    inside = {(a.name, b.name) for a, b in permutations(types, 2) if contained_in(a, b)}
    for a, b in sorted(inside):
        if (b, a) not in inside:
            yield f"{a}: its cloud is contained in that of {b}: wherever {b} stands, {a} fits as well"
        elif a < b:
            yield f"{a}: its cloud is the same as that of {b}: nothing tells them apart"


def _same_clouds(learned: list[ObjectType]) -> Iterator[str]:
    """Types that were learned from the same mesh and paint."""
    first: dict[bytes, str] = {}
    for kind in learned:
        assert kind.learned is not None  # noqa: S101 - the caller chose
        looks = kind.learned.at.tobytes() + kind.learned.descriptor.tobytes()
        if looks in first:
            yield f"{kind.name}: its cloud is the same as that of {first[looks]}: nothing tells them apart"
        first.setdefault(looks, kind.name)


CLOSE = 0.01
"""How far features may be from each other's places, as a share of the smaller cloud's diameter."""
MOST_TRIES = 5_000
"""Placements of the smaller cloud in the larger one that are tried; of more, nothing is said."""


def contained_in(small: ObjectType, large: ObjectType) -> bool:
    """Whether a rigid motion takes every feature of ``small`` to one of ``large`` of the same type."""
    if small is large or not small.features:
        return False
    mine, theirs = Counter(f.type for f in small.features), Counter(f.type for f in large.features)
    if any(theirs[name] < number for name, number in mine.items()):
        return False
    at, there = (np.array([f.at for f in kind.features]) for kind in (small, large))
    same = np.array([[f.type == g.type for g in large.features] for f in small.features])
    near = CLOSE * float(np.linalg.norm(np.ptp(at, axis=0))) + 1e-9
    for held, found in _placements(at, there, same, near):
        moved = _moved(at, at[held], there[found])
        distance = np.linalg.norm(moved[:, None] - there[None], axis=2)
        if ((distance <= 2 * near) & same).any(axis=1).all():
            return True
    return False


def _placements(at: Floats, there: Floats, same: Mask, near: float) -> Iterator[tuple[list[int], list[int]]]:
    """Up to three features of the one, rare and far apart, with where they may be in the other.

    Types and distances agree.
    """
    held = _wide(at, same.sum(axis=1))
    ways: list[list[int]] = [[]]
    for index, feature in enumerate(held):
        longer = []
        for way in ways:
            fits = same[feature].copy()
            for other, place in zip(held[:index], way, strict=True):
                gap = np.linalg.norm(at[feature] - at[other])
                fits &= np.abs(np.linalg.norm(there - there[place], axis=1) - gap) <= 2 * near
            longer += [[*way, int(place)] for place in np.flatnonzero(fits) if place not in way]
        ways = longer[: 4 * MOST_TRIES]
    yield from ((held, way) for way in ways[:MOST_TRIES])


def _wide(at: Floats, rare: NDArray[np.intp]) -> list[int]:
    """The rarest feature, the farthest from it, and the farthest from the line through both.

    Fewer where no more are apart.
    """
    held = [int(np.argmin(rare))]
    distance = np.linalg.norm(at - at[held[0]], axis=1)
    if distance.max() <= 0:
        return held
    held.append(int(distance.argmax()))
    line = (at[held[1]] - at[held[0]]) / distance.max()
    off = np.linalg.norm(np.cross(at - at[held[0]], line), axis=1)
    return [*held, int(off.argmax())] if off.max() > CLOSE * distance.max() else held


def _moved(points: Floats, here: Floats, there: Floats) -> Floats:
    """``points`` (N, 3) by the rigid motion that best takes ``here`` to ``there`` (Kabsch)."""
    a, b = here.mean(axis=0), there.mean(axis=0)
    u, _, v = np.linalg.svd((here - a).T @ (there - b))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v)) or 1.0])
    return (points - a) @ (u @ mirror @ v) + b


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
    reach = np.clip(AWAY * _size(kind), table.r_min, table.r_max)
    viewpoints = table.at[:, None] + reach[:, None, None] * directions
    shown = _shown(kind, viewpoints.reshape(-1, 3), np.repeat(table.at, directions.shape[1], axis=0))
    seen = np.zeros(table.features, dtype=bool)
    np.logical_or.at(seen, np.repeat(table.feature, directions.shape[1]), shown)
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
            seen = _shown(kind, np.broadcast_to(viewpoints[index], (len(chosen), 3)), at[chosen]).sum()
            most = max(most, int(seen))
        if most >= FIXING_A_POSE:
            return FIXING_A_POSE
    return most


def _viewpoints(kind: ObjectType, table: LobeTable) -> Floats:
    """Round the type at a few distances, and along some lobes' axes."""
    middle = np.sqrt(np.maximum(table.r_min, 1e-3 * table.r_max) * table.r_max)
    usual = np.clip(AWAY * _size(kind), np.median(table.r_min), np.median(table.r_max))
    distances = np.unique([usual, *np.quantile(middle, [0.1, 0.5, 0.9])])
    centre = kind.surface.centre if kind.surface is not None else table.at.mean(axis=0)
    round_it = [centre + distance * even_directions(DIRECTIONS) for distance in distances]
    some = np.linspace(0, len(middle) - 1, min(len(middle), DIRECTIONS)).astype(int)
    along = table.at[some] + np.clip(usual, table.r_min[some], table.r_max[some])[:, None] * table.axis[some]
    return np.concatenate([*round_it, along])


def _size(kind: ObjectType) -> float:
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


def _shown(kind: ObjectType, viewpoints: Floats, points: Floats) -> Mask:
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
