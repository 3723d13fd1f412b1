"""Σo: object types as feature clouds (§2).

Vocabulary, each with an example value:

* ``Lobe``, from where an appearance is seen: ``Lobe(axis=(0, 0, 1), half_angle=1.7, r_min=0.2, r_max=30.0)``
* ``FeatureAppearance``, one way that a feature looks: ``FeatureAppearance("arrow_junction", lobe)``
* ``Feature``: ``Feature("roof/apex", "apex", at=(0, 0, 3), ...)``
* ``Stand``, how a type stands, as its author says: ``Stand(down=(0, 0, -1), weight=0.8)``
* ``ObjectType``: ``ObjectType("t2", tree, features, ...)``, the tree being one with frames on its edges
* ``KnowledgeBase``: ``KnowledgeBase("towers", types=(t1, t2), ...)``
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import lengths
from geometry.bodies.resting import RestingFaces, resting_faces, stated_faces
from kb.clouds.learned import LearnedCloud
from kb.clouds.lobes import Feature, LobeTable, Tree, freeze, lobe_table, object_nodes
from kb.clouds.words import Words
from kb.surfaces.faces import faces
from kb.surfaces.surface import Surface

UNKNOWN_SUPPORT = 0.1
"""Chance that something which the KB does not know holds what floats, where `gravity` does not say: one in ten things
that seem to float."""


SAME_PLACE = 1e-3
"""A vertex and a feature are in one place that are nearer than this share of the surface's diameter: meshes are written
to three or four digits."""


class Stand(NamedTuple):
    """``down`` (3,), unit, object frame: the direction that is below; ``weight`` above 0, of any sum."""

    down: tuple[float, ...]
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class ObjectType:
    """One type of maximal object (D3).

    ``features`` are the maximal features: valuation and ev score a compound once and not its parts again (A1).
    ``all_features`` is every Feature node, which S of §5.1 counts. ``symmetries`` (S, 4, 4): rigid motions of the
    object's frame that change nothing, the identity among them. A type without a mesh has no ``surface`` and hides
    nothing. ``mesh_file`` is what is rendered, the textured mesh where there is one; ``mesh_scale`` is metres per unit
    of it. ``learned``: the cloud of a type whose features were learned; ``learned_features`` are then the same in the
        same
    order, but their appearances are ``learned_lobes``. Those that make up a compound are its parts, and no maximal
    features. ``stands``: how its author says that it stands; empty where it never does, None where nothing is said.
    """

    name: str
    tree: Tree
    features: tuple[Feature, ...]
    all_features: tuple[Feature, ...]
    surface: Surface | None
    opaque: bool
    symmetries: NDArray[np.float64]
    mesh_file: Path | None = None
    mesh_scale: float = 1.0
    learned: LearnedCloud | None = None
    learned_lobes: LobeTable | None = None
    learned_features: tuple[Feature, ...] | None = None
    stands: tuple[Stand, ...] | None = None

    def __post_init__(self) -> None:
        freeze(self, symmetries=(-1, 4, 4))

    @cached_property
    def seen_features(self) -> tuple[Feature, ...]:
        """F features that appearances are matched to, and that ``lobes`` are of.

        ``features``, but of a compound its atomic parts (D2).
        """
        if self.learned_features is None and any(feature.parts for feature in self.features):
            return tuple(feature for feature in self.all_features if not feature.parts)
        return self.features if self.learned_features is None else self.learned_features

    @cached_property
    def resting(self) -> RestingFaces:
        """The faces that it stands on, with weights: as its author says, or as its surface can; none without one.

        What its author says of a face holds of those that symmetries take it to: they share the weight.
        """
        points = np.zeros((0, 3)) if self.surface is None else self.surface.vertices
        if self.stands is None or not len(points):
            return resting_faces(points)
        turns = self.symmetries[:, :3, :3]
        down = np.array([turns @ stand.down for stand in self.stands]).reshape(-1, 3)
        weight = np.repeat([stand.weight for stand in self.stands], len(turns)) / len(turns)
        return stated_faces(points, down, weight) if len(down) else resting_faces(points[:0])

    @cached_property
    def whole(self) -> NDArray[np.intp]:
        """(F,) which of ``features`` each of ``seen_features`` is, or is a part of."""
        place = {feature.name: i for i, feature in enumerate(self.features)}
        ways = [accumulate(feature.name.split("/"), "{}/{}".format) for feature in self.seen_features]
        return np.array([next(place[node] for node in way if node in place) for way in ways], np.intp)

    @cached_property
    def kind_codes(self) -> tuple[tuple[str, ...], NDArray[np.intp]]:
        """The different feature types of ``features`` in alphabetical order, and (F,) which of them each has."""
        names = tuple(sorted({feature.type for feature in self.features}))
        place = {name: i for i, name in enumerate(names)}
        return names, np.array([place[feature.type] for feature in self.features], np.intp)

    @cached_property
    def part_bodies(self) -> dict[str, Surface]:
        """The bodies, object frame, of the parts that are objects, by node, in the tree's order.

        The maximal object is not among them.
        """
        parts = [node for node in object_nodes(self.tree) if node]
        features = self.seen_features
        if self.surface is None or not parts or not features:
            return {}
        middles = self.surface.vertices[self.surface.triangles].mean(axis=1)
        nearest = _nearest(middles, np.array([feature.at for feature in features]))
        owner = [_owner(self.tree, feature.name) for feature in features]
        owners = [owner[f] for f in nearest]
        bodies = {part: np.flatnonzero([own == part or own.startswith(f"{part}/") for own in owners]) for part in parts}
        return {part: _body(self.surface, facets) for part, facets in bodies.items() if len(facets)}

    @cached_property
    def facets(self) -> tuple[tuple[str, ...], ...]:
        """The facets of the surface of which each vertex is where a feature is, by the features' names (§4.2)."""
        return () if self.surface is None else self._named(self.surface.triangles.tolist())

    @cached_property
    def faces(self) -> tuple[tuple[str, ...], ...]:
        """The faces of the surface of which each corner is where a feature is, by the features' names (§4.2)."""
        return () if self.surface is None else self._named([face.loop for face in faces(self.surface)])

    def _named(self, polygons: Iterable[Sequence[int]]) -> tuple[tuple[str, ...], ...]:
        """The polygons, of vertices of the surface, whose vertices are all where features are, by their names."""
        features, surface = self.seen_features, self.surface
        if surface is None or not features:
            return ()
        at = np.array([feature.at for feature in features])
        nearest = _nearest(surface.vertices, at)
        here = np.linalg.norm(surface.vertices - at[nearest], axis=1) <= SAME_PLACE * surface.diameter
        name = [features[f].name if there else "" for f, there in zip(nearest, here, strict=True)]
        named = (tuple(name[v] for v in polygon) for polygon in polygons)
        return tuple(corners for corners in named if all(corners))

    @cached_property
    def lobes(self) -> LobeTable:
        """The lobes of ``seen_features`` as arrays."""
        return self.learned_lobes or lobe_table(self.seen_features)


@dataclass(frozen=True)
class Counts:
    """What rates were learned from: [n, of] per name, expected counts where not everything was observed.

    ``hit``: detected, of the expected, per feature type. ``clutter``: appearances of noise, of so many images, per
    appearance type. ``prior``: present, of so many instances and empty images, per object type.
    """

    hit: dict[str, tuple[float, float]] = field(default_factory=dict)
    clutter: dict[str, tuple[float, float]] = field(default_factory=dict)
    prior: dict[str, tuple[float, float]] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.hit or self.clutter or self.prior)


@dataclass(frozen=True)
class Rates:
    """Detector statistics and priors of a KB.

    ``hit``: h_F per feature type. ``clutter``: expected clutter appearances an image per appearance type. ``prior`` per
    object type. ``sigma``: location noise, pixels; ``sigmas`` per feature type where it differs. ``match_tolerance``:
    pixels (D8). ``counts``: what was learned from scenes (``plogic kb learn-rates``). ``sigma_angle``: noise, radians,
    of a datum's angle, which is how the x axis of its feature's frame lies on the screen; None where angles say
    nothing.
    """

    hit: dict[str, float]
    clutter: dict[str, float]
    prior: dict[str, float]
    sigma: float = 1.0
    match_tolerance: float = 4.0
    sigmas: dict[str, float] = field(default_factory=dict)
    counts: Counts = field(default_factory=Counts)
    sigma_angle: float | None = None

    def sigma_of(self, feature_type: str) -> float:
        """Location noise of a feature type, pixels."""
        return self.sigmas.get(feature_type, self.sigma)


@dataclass(frozen=True, eq=False)
class KnowledgeBase:
    """Σ.

    ``f_ref`` pixels: the focal length that lobes' ranges hold for. ``digest``: SHA-256 over the folder's contents.

    ``words``: the visual words of learned clouds; their names are among ``appearance_types``. ``gravity``: whether
    things rest on what is below; then ``unknown_support`` is the chance that something unknown holds what floats, and
    ``ground`` the ground's height, world z in m, None where it is not told. ``maybe``: they may rest, on planes that
    nobody knows, and what floats is no less probable for that.
    """

    name: str
    types: tuple[ObjectType, ...]
    appearance_types: tuple[str, ...]
    rates: Rates
    f_ref: float
    rules: str
    digest: str
    folder: Path | None = None
    words: Words | None = None
    gravity: bool = False
    maybe: bool = False
    unknown_support: float = UNKNOWN_SUPPORT
    ground: float | None = None

    @cached_property
    def sought(self) -> tuple[str, ...]:
        """Those of ``appearance_types`` that some feature may look like, and all words: what a detector is asked for.

        Others would be noise.
        """
        used = {name for kind in self.types for name in kind.lobes.types}
        used.update(self.words.names if self.words is not None else ())
        return tuple(name for name in self.appearance_types if name in used)

    @property
    def rests(self) -> float | None:
        """Chance that a thing rests on another, on a plane or on the ground; None where nobody said that they do."""
        return 1.0 - self.unknown_support if self.gravity or self.maybe else None

    def type(self, name: str) -> ObjectType:
        """The type of a name; raises KeyError."""
        return {t.name: t for t in self.types}[name]


LAMBDA = 1.0
"""Clutter appearances an image, per appearance type of the vocabulary, on the average."""
KEYPOINTS = 4000.0
"""Keypoints of clutter an image, of all visual words together."""
LEAST = 0.01
"""Share of that average that an appearance type has at least, though no feature looks like it."""


def clutter_prior(types: Sequence[ObjectType], appearance_types: Sequence[str]) -> dict[str, float]:
    """Expected clutter appearances an image per appearance type: λ in all, shared out by P(dv(F)).

    P(dv(F)) = |S(F)|/|S| of a feature type F is divided evenly among the appearance types that F can look like.
    """
    instances: Counter[str] = Counter()
    looks: dict[str, set[str]] = {}
    for feature in (feature for kind in types if kind.learned is None for feature in kind.all_features):
        instances[feature.type] += 1
        looks.setdefault(feature.type, set()).update(appearance.type for appearance in feature.appearances)
    total, share = sum(instances.values()), dict.fromkeys(appearance_types, 0.0)
    for kind, number in instances.items():
        for name in looks[kind]:
            share[name] += number / total / len(looks[kind])
    whole = LAMBDA * len(appearance_types)
    return {name: round(max(whole * part, LEAST * LAMBDA), 6) for name, part in share.items()}


def word_clutter(types: Sequence[ObjectType], words: Sequence[str]) -> dict[str, float]:
    """Expected keypoints of clutter an image per visual word.

    ``KEYPOINTS`` in all, shared out by P(dv(F)), each word having one feature at least.

    Of the features that keypoints are matched to: a compound has no keypoint besides those of its parts.
    """
    seen = Counter(dict.fromkeys(words, 1))
    seen.update(feature.type for kind in types if kind.learned is not None for feature in kind.seen_features)
    total = sum(seen.values())
    return {name: KEYPOINTS * seen[name] / total for name in words}


FEW = 100_000
"""Distances that are all computed; of more, a tree is searched."""


def _nearest(points: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.intp]:
    """(N,) the place (P, 3) nearest to each of the points (N, 3); the first of equals."""
    if len(points) * len(places) <= FEW:
        table = lengths(points[:, None] - places)
        return (table <= table.min(axis=1, keepdims=True) * (1 + 1e-9) + 1e-12).argmax(axis=1)
    from scipy.spatial import cKDTree

    far = cKDTree(places).query(points)[0]
    close = cKDTree(places).query_ball_point(points, far * (1 + 1e-9) + 1e-12)
    return np.array([min(some) for some in close], dtype=np.intp)


def _owner(tree: Tree, name: str) -> str:
    """The innermost object on the path to a feature; '' for the maximal one."""
    steps = name.split("/")
    paths = ("/".join(steps[:n]) for n in range(len(steps) - 1, 0, -1))
    return next((path for path in paths if path in tree.nodes and tree.nodes[path].kind == "object"), "")


def _body(surface: Surface, facets: NDArray[np.intp]) -> Surface:
    used, index = np.unique(surface.triangles[facets], return_inverse=True)
    return Surface(surface.vertices[used], index.reshape(-1, 3))
