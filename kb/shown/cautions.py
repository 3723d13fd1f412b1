"""What in a knowledge base is no mistake and yet matters: what will never be found, or be found where it is not.

``LearnedSummary``: a learned type in a few lines, how much there is of it, how surely it is seen, and from where enough
of it is expected.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Mask
from geometry.cones import even_directions
from geometry.files.mesh_files import textures_in
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud
from kb.clouds.lobes import in_lobe
from kb.shown.misfits import misfits
from kb.shown.seen_from import DIRECTIONS, FIXING_A_POSE, most_together, named, unseen_features, usual_distance

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
    distance = usual_distance(kind)
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


MOST_LISTED = 5
"""Types that one sentence names."""
MOST_TYPES = 60
"""Types that are compared with each other."""


def cautions(kb: KnowledgeBase) -> Iterator[str]:
    """A sentence about each, the KB's own first, then by type."""
    alike = one_feature_type(kb)
    if alike:
        yield alike
    yield from _of_noise(kb)
    for kind in kb.types:
        yield from (f"{kind.name}: {text}" for text in of_type(kind, kb.f_ref))
    yield from _contained(tuple(kind for kind in kb.types if kind.learned is None)[:MOST_TYPES])
    yield from _same_clouds([kind for kind in kb.types if kind.learned is not None])


def one_feature_type(kb: KnowledgeBase) -> str:
    """That all features are of one type, so that no ev is defined; '' where they are of more, or there are none."""
    sorts = {feature.type for kind in kb.types for feature in kind.all_features}
    if len(sorts) != 1:
        return ""
    return (
        f"every feature is of type {sorts.pop()!r}, so that every dv is 0 and ev is undefined: nothing will be accepted"
    )


def _of_noise(kb: KnowledgeBase) -> Iterator[str]:
    """Where places are noisier than they may be, the worst type."""
    sorts = sorted({feature.type for kind in kb.types if kind.learned is None for feature in kind.all_features})
    sigma, name = max(((kb.rates.sigma_of(name), name) for name in sorts), default=(0.0, ""))
    if sigma > kb.rates.match_tolerance:
        what = f"sigma of {name} is {sigma:g} pixels, more than match_tolerance, {kb.rates.match_tolerance:g}"
        yield f"{what}: most correct data are too far off to be matched; raise match_tolerance in kb.yaml to {3.0 * sigma:g} or so"


def of_type(kind: ObjectType, f_ref: float) -> Iterator[str]:
    """A sentence about each thing in one type; ``f_ref`` pixels: the focal length that its ranges hold for."""
    if not kind.features:
        yield from _of_mesh(kind)
        yield f"has no features, so it is never found: {remedy(kind)}"
        return
    unfit = [] if kind.learned is not None else list(misfits(kind, f_ref))
    yield from unfit
    yield from _of_mesh(kind)
    if kind.learned is not None:
        yield from _of_learned(kind)
    elif not unfit:  # else what follows from these would be told as well
        yield from _of_lobes(kind)


BY_HAND = "write junctions, patches, markers or colour blobs into object.yaml by hand"
UNPAINTED = (
    "its mesh has no texture, so keypoints see nothing of it; lay a photo on it (plogic kb learn NAME --photo FILE "
    f"--points FILE --kb KB), or {BY_HAND}"
)


def remedy(kind: ObjectType, options: str = "") -> str:
    """What gives a type without features some; ``options`` of the command that would learn them."""
    if kind.mesh_file is None:
        return f"it has no mesh to learn them from; {BY_HAND}"
    if not textures_in(kind.mesh_file)[0]:
        return UNPAINTED
    learn = f"plogic kb learn {options or f'{kind.name} --kb KB'}"
    return f"learn them: {learn}; where that says that its texture is too plain, {BY_HAND}"


def _of_lobes(kind: ObjectType) -> Iterator[str]:
    unseen = unseen_features(kind)
    if unseen:
        yield unseen_told(unseen)
    together = most_together(kind)
    if len(kind.seen_features) < FIXING_A_POSE:
        yield f"has {len(kind.seen_features)} features, and a pose is taken from {FIXING_A_POSE}: it is never found"
    elif together < FIXING_A_POSE and len(unseen) < len(kind.seen_features):
        yield f"its lobes never meet: no viewpoint was found that sees {FIXING_A_POSE} features at once ({together} at most), so it is never found"


def unseen_told(unseen: list[str]) -> str:
    """Of the features that ``unseen_features`` names."""
    return f"no viewpoint sees {named(unseen)}: the lobes lie inside or behind the type's own body"


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
    for texture in textures_in(kind.mesh_file)[0] if kind.mesh_file is not None else ():
        if texture.data is None:
            why = texture.fault or "is missing"
            yield f"the {texture.label} of its mesh {why}, so that it cannot be drawn"


def _contained(types: tuple[ObjectType, ...]) -> Iterator[str]:
    """Types that nothing tells apart, a sentence a group; and groups of which others have all features, too."""
    inside = cache(lambda a, b: contained_in(by_name[a], by_name[b]))
    by_name, groups = {kind.name: kind for kind in types}, list[list[str]]()
    for name in sorted(by_name):
        group = next((some for some in groups if inside(name, some[0]) and inside(some[0], name)), None)
        if group is None:
            groups.append([name])
        else:
            group.append(name)
    yield from _same(groups)
    for some in groups:
        around = [name for other in groups if other is not some and inside(some[0], other[0]) for name in other]
        if around:
            stands = around[0] if len(around) == 1 else "one of them"
            fits = some[0] if len(some) == 1 else "each of these"
            yield f"{_listed(some)}: its cloud is contained in that of {_listed(around)}: wherever {stands} stands, {fits} fits as well"


def _same_clouds(learned: list[ObjectType]) -> Iterator[str]:
    """Types that were learned from the same mesh and paint."""
    groups: dict[bytes, list[str]] = {}
    for kind in learned:
        assert kind.learned is not None  # noqa: S101 - the caller chose
        groups.setdefault(kind.learned.at.tobytes() + kind.learned.descriptor.tobytes(), []).append(kind.name)
    yield from _same(groups.values())


def _same(groups: Iterable[list[str]]) -> Iterator[str]:
    for first, *others in groups:
        if others:
            yield f"{first}: its cloud is the same as that of {_listed(others)}: nothing tells them apart"


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MOST_LISTED
    return ", ".join(names[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


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
